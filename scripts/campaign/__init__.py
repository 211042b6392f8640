"""The accuracy campaign: thousands of contacts of every kind, solved as users do and compared with
independent solutions."""
