"""The linear model on shapes: what a formula explains of the operators, how sure that is, and where."""
