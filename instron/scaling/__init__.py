"""From a force log to f(x): stroke, zero, noise, end of combing, highest force."""
