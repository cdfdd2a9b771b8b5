"""What accuracy costs: three problems solved again and again with one knob turned at a time."""
