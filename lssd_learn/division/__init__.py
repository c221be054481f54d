"""Who is trained on, who chooses the epoch, who is the test; free of Lightning, for what trains nothing asks too."""
