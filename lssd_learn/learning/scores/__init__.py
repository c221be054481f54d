"""How good what was learnt is: parameter by parameter, and shape by shape beside the true surface."""
