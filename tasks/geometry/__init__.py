"""The ground floor: mathematics that several stages need, without a stage's words in it."""
