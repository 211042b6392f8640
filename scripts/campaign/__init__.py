"""The accuracy campaign: thousands of contacts of every kind, solved as a user would and compared
with an independent solution."""
