"""One idea per file: OBSERVABLES = {name: function(contact) -> number or None}. None is left out of the result.

`contact` is a contact.Contact; sums that several observables share are its cached properties, so that what nobody asks for is not
computed. Numbers are in the scene's units.
"""
