"""The papers behind a result."""

import json

from ..bodies import body_of
from ..contact import all_observables
from ..output.result import Result
from ..solvers import solver_class

PAPER = "Prodanov, Dapp, Müser, Tribol. Lett. 53 (2014) 433, doi:10.1007/s11249-013-0282-z"


def references_of(result: Result) -> list[str]:
    """Return what to cite for a result: the program, papers of body, algorithm, theory."""
    # theories, which a solve has no need of
    from ..plotting.theory import theory_of

    scene = result.scene
    names = {name for step in result.steps for name in step}
    version = json.loads(result.head.get("versions", "{}")).get("hpc_gfmd", "")
    theory = theory_of(scene, result.surface)
    papers = [f"hpc-gfmd {version}".strip(), PAPER]
    papers += body_of(scene.material, scene.surface.free).sources
    papers += solver_class(scene.solver.name).sources
    for name, observable in all_observables().items():
        papers += observable.sources if name in names else ()
    return list(dict.fromkeys(papers + list(theory.sources if theory else ())))
