"""Force logs: machine exports read exactly or refused, and scaled to f and x."""
