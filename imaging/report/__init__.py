"""What is handed over: tables, pictures, figures, regions for ImageJ."""
