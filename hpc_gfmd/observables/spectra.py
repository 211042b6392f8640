"""Power spectra and autocorrelations of heights, pressure and gap, averaged over directions: see operators/spectra.py."""

PERIODIC = True
FIELDS = ("heights", "pressure", "gap")
DISTRIBUTIONS = {f"{name}_spectrum": lambda contact, name=name: contact.spectra.power(name) for name in FIELDS} | {
    f"{name}_autocorrelation": lambda contact, name=name: contact.spectra.autocorrelation(name) for name in FIELDS}
