"""New shapes as mixtures of known ones that correspond to one another: span → fit (net → bend) → spanned."""
