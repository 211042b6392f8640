"""One idea per file: OBSERVABLES = {name: Observable(function of a contact, meaning, unit)}. A
function returns a number, or None, which is left out of the result.

ON_REQUEST = True marks a file whose observables take FFT pairs or passes over the fields of their
own: only where the scene names them. TOGETHER = {name: names of observables} has names that stand
for several. DISTRIBUTIONS = {name: Distribution(function of a contact, meaning, units)}, always on
request, becomes the attributes NAME_WHAT of a load step; PERIODIC = True: not for surfaces that
end. base.py has these classes, and what is said of the other numbers of a load.

`contact` is a contact.Contact; sums that several observables share are its cached properties, so
that what nobody asks for is not computed. Numbers are in the scene's units.
"""
