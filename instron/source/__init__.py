"""A file as text: encodings, line ends, workbooks, and what is no export."""
