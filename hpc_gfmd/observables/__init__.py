"""One idea per file: OBSERVABLES = {name: function(contact) -> number or None}. None is left out of the result.

ON_REQUEST = True marks a file whose observables take FFT pairs of their own: only where the scene names them.

`contact` is a contact.Contact; sums that several observables share are its cached properties, so that what nobody asks for is not
computed. Numbers are in the scene's units.
"""
