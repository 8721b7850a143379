"""What the page answers, by topic."""
