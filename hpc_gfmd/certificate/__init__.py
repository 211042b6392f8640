"""The independent check of a solution and the errors that follow from it."""
