"""States at rest: the balance of couples, Newton's method for it, and when a march is handed on."""
