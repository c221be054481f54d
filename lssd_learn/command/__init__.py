"""What is settled about a command before it runs: its words, its folder, its sizes, what of it is done already."""
