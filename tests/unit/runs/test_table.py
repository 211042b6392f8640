"""The table of results, one-line summaries, and `show`."""

from result_files import STEP, SURFACE, begin
from scene_tables import rows

from hpc_gfmd.output.summary import summary, with_error
from hpc_gfmd.runs.table import table


def test_the_area_of_the_grid_is_too_large():
    """Its bar is on the side of the edge correction; the corrected one has what is left of it."""
    step = STEP | {"a_r_error": 0.01, "a_r_discretisation": 0.11, "a_r_corrected": 0.225}
    text = table({0: step}, {})
    row = [cell.strip() for cell in text.splitlines()[2].split("  ")]
    assert "25 +1 -3" in row
    assert "22 +- 1" in row  # 0.35 of the correction, what is at random, and the solver's
    assert summary(step, SURFACE).startswith("a_r = 25 +1 -3 % (corrected 22 +- 1 %), ")
    pressed = table({0: step | {"contact_pressure_mean": 0.4}}, {}).splitlines()[2]
    assert "0.40 +0.05 -0.01" in pressed  # 0.1/0.225, and less of the load over that
    small = step | {"a_r": 2.5e-7, "a_r_corrected": 2.25e-7, "a_r_error": 0.02}
    assert "a_r = (2.5 +0.1 -0.3)e-05 %" in summary(small, SURFACE)


def test_errors_of_time_steps_are_not_in_the_bars():
    """Which the lines below the table say where loads have several times."""
    times = {k: STEP | {"time": time} for k, time in enumerate((0.0, 1.0))}
    assert "+-: without the error of the time steps (see hpc-gfmd run --halve-steps)" in table(
        times, {}
    )
    assert "--halve-steps" not in table({0: times[0], 1: times[0]}, {})
    assert "--halve-steps" not in table({0: STEP, 1: STEP}, {})


def test_requested_observables_have_a_column_or_a_reason():
    step = STEP | {"stiffness": 3.0, "gap_spans_x": True}
    text = table({0: step}, {}, ["stiffness", "conductance", "gap_spans_x"])
    heading, _, row, *below = text.splitlines()
    shown = dict(zip(heading.split()[4:], row.split()[6:], strict=False))
    assert shown["stiffness"] == "3"
    assert shown["conductance"] == "-"
    assert "yes" in row
    (reason,) = (line for line in below if "conductance" in line)
    assert "step 0" in reason
    assert "stiffness" not in "".join(below)


DIGITS = rows("""
0.016049 | 1.2e-3 | 0.01605 +- 0.00002
3.2e-5 | 1e-2 | (3.20 +- 0.03)e-05
2.27 |  | 2.27
2.27 | nan | 2.27 +- ?
0.0 | 1e-3 | 0
1.0 | 0.0 | 1 +- 0
nan | 1e-3 | nan
0.5 | 3.0 | 0.5 +- 1.5
0.016049 | 1e-9 | 0.0160490 +- 2e-11
""")


def test_digits_follow_the_error():
    for value, error, text in DIGITS:
        assert with_error(float(value), float(error) if error else None) == text


def test_show_prints_table_and_json(path, cli):
    with begin(path) as run:
        run.write_step(0, STEP | {"gap_mean": float("inf"), "status": "max_iterations"})
        run.finish("max_iterations")
    text = cli.prints("show", path)
    assert "6 x 5 points, L = 1 x 2, h_rms = 0.5" in text
    assert "NOT CONVERGED (max_iterations)" in text
    data = cli.data("show", path)
    assert data["steps"][0]["gap_mean"] is None
    assert data["surface"] == SURFACE
