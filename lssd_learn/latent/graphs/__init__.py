"""Which pairs of a collection are mapped: graphs on its shapes, from points whose distances tell which are alike."""
