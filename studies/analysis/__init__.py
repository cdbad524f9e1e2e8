"""What the answers to a study say, and how surely."""
