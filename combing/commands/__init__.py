"""One module per subcommand of ``combing``."""
