"""The report's sections, and that a folder makes the same report as the calibration that wrote it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import elastocal as ec
from elastocal.io import RESULT_FILES, as_saved
from elastocal.io.covariances import MOST_SHOWN, covariance_from, covariance_table
from elastocal.report.calibration import report_sections
from elastocal.report.documents import calibration_report
from elastocal.report.html import CELLS, MARKS
from elastocal.report.section import Section
from support.calibrations import measured
from support.files import Desk, contents, desk, save_simulated
from support.robots import arm, placed

__all__ = ["desk"]

COMMAND = "calibrate robot.toml fit.csv --held-out held_out.csv --elastic 2:step,3:hinge -o result"


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Desk:
    """A desk with the result of a calibration with two searched torques."""
    found = Desk(tmp_path_factory.mktemp("sections"))
    save_simulated(found.folder, fit=50)
    found.done(COMMAND)
    return found


def named(sections: list[Section], title: str) -> Section:
    return next(section for section in sections if section.title == title)


def test_a_folder_makes_the_report_that_calibrate_wrote(calibrated: Desk):
    path = calibrated.folder / "result" / "report.html"
    written = path.read_bytes()
    ran = calibrated.run("report result")
    assert ran.err == "result/report.html\n"
    assert path.read_bytes() == written
    calibrated.done("report result -o elsewhere.html")
    assert (calibrated.folder / "elsewhere.html").read_bytes() == written
    assert ec.report_html(ec.load_result(calibrated.folder / "result")).encode() == written


def test_a_result_says_the_same_before_and_after_it_was_saved(desk: Desk):
    rng = np.random.default_rng(2)
    result = ec.calibrate(arm(), measured(placed(arm(), rng), 40, 5, noise=1e-5), transmission=2)
    ec.save_result(result, desk.folder / "saved")
    assert ec.report_html(result) == ec.report_html(ec.load_result(desk.folder / "saved"))
    ec.save_report(result, desk.folder / "saved" / "report.html")
    assert (desk.folder / "saved" / "report.html").read_text(encoding="utf-8") == ec.report_html(result)


def test_all_that_calibrate_knew_is_read_again(calibrated: Desk):
    found = ec.load_result(calibrated.folder / "result")
    assert [e.law for e in found.elastic] == ["step", "hinge"]
    for element in found.elastic:
        assert element.transition is not None
        assert element.transition.curve is not None
        assert min(element.transition.curve.rises) == 0.0
        assert np.all(np.diff(element.transition.curve.torques) > 0.0)
    assert found.search is not None
    assert found.search.pair is not None
    assert found.search.pair.elements == ("2.theta", "3.theta")
    assert np.min(found.search.pair.rises) == 0.0
    assert np.shape(found.search.pair.rises) == tuple(map(len, found.search.pair.torques))
    seen = found.observability
    assert seen is not None
    assert len(seen.singular_values) == seen.parameters
    assert seen.singular_values[0] / seen.singular_values[-1] == pytest.approx(seen.condition)
    assert sum(share**2 for share in seen.weakest.values()) == pytest.approx(1.0)
    assert found.errors is not None
    held = found.errors.held_out
    assert np.sqrt(np.mean(found.errors.calibrated.norms[held] ** 2)) == pytest.approx(found.residuals["held_out"].rms)


def test_every_section_of_the_issue_is_there(calibrated: Desk):
    sections = report_sections(ec.load_result(calibrated.folder / "result"))
    titles = [section.title for section in sections]
    for title in (
        "Verdict",
        "Errors before and after",
        "Error vectors",
        "What is not yet modelled",
        "Residual against joint position",
        "Residual against joint torque",
        "Torque and deflection",
        "Search for transition torques",
        "Identified parameters",
        "Deviations from nominal",
        "Correlations",
        "Observability",
        "Outliers",
        "Accuracy over the workspace",
        "How to make it again",
    ):
        assert title in titles
    assert titles[0] == "Verdict"
    assert all(section.verdict is None or section.verdict.kind in MARKS for section in sections)
    assert len(named(sections, "Torque and deflection").panels) == 2
    assert len(named(sections, "Search for transition torques").panels) == 3  # each torque, and both


def test_how_to_make_it_again_makes_it_again(calibrated: Desk):
    result = ec.load_result(calibrated.folder / "result")
    origin = named(report_sections(result), "How to make it again")
    command = origin.code.removeprefix("elastocal ").replace("-o result", "-o again")
    before = json.loads((calibrated.folder / "result" / "result.json").read_text())
    calibrated.done(command)
    after = json.loads((calibrated.folder / "again" / "result.json").read_text())
    for key in ("parameters", "residuals", "elastic", "data_sha256"):
        assert after[key] == before[key]
    assert [row[2] for row in origin.rows if row[0] == "data"] == before["data_sha256"]


def test_a_name_with_blanks_is_quoted_in_the_command(desk: Desk):
    save_simulated(desk.folder)
    (desk.folder / "fit.csv").rename(desk.folder / "my fit.csv")
    desk.done("calibrate robot.toml 'my fit.csv' --fix '*.beta' 2.b --prior -o result")
    code = named(report_sections(ec.load_result(desk.folder / "result")), "How to make it again").code
    assert code == "elastocal calibrate robot.toml 'my fit.csv' --fix '*.beta' 2.b --prior -o result"


def test_an_earlier_report_does_not_stay_beside_a_newer_result(desk: Desk):
    rng = np.random.default_rng(2)
    result = ec.calibrate(arm(), measured(placed(arm(), rng), 40, 5, noise=1e-5))
    folder = desk.folder / "result"
    assert ec.save_result(result, folder, report=calibration_report) == RESULT_FILES
    assert (folder / "report.html").is_file()
    assert ec.save_result(result, folder) == RESULT_FILES[:-1]
    assert not (folder / "report.html").exists()


def test_a_folder_of_an_earlier_version_has_a_report_of_what_it_has(calibrated: Desk, desk: Desk):
    """No curves, singular values or orientations were kept then; without residuals.csv there are no rows at all."""
    folder = desk.folder / "old"
    folder.mkdir()
    for name in RESULT_FILES[:-1]:
        (folder / name).write_bytes((calibrated.folder / "result" / name).read_bytes())
    values = json.loads((folder / "result.json").read_text())
    for key in ("tolerance", "transmission", "correlated"):
        del values[key]
    for key in ("singular_values", "weakest"):
        del values["observability"][key]
    del values["search"]["pair"], values["settings"]["command"]
    for element in values["elastic"]:
        del element["curve"], element["searched"]
    (folder / "result.json").write_text(json.dumps(values))
    titles = [section.title for section in report_sections(ec.load_result(folder))]
    assert "Torque and deflection" in titles
    assert "Search for transition torques" not in titles
    (folder / "residuals.csv").unlink()
    left = [section.title for section in report_sections(ec.load_result(folder))]
    assert {"Verdict", "Torque and deflection", "Identified parameters", "Correlations"} <= set(left)
    assert "Error vectors" not in left


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda text: text.replace("q1", "p1"), "columns q1 are missing"),
        (lambda text: text.replace("fitted", "fitted,1", 1), "not the residuals that a calibration wrote"),
        (lambda _: "", "not the residuals that a calibration wrote"),
        (lambda text: text.replace("nominal_", "n_"), "column nominal_error [mm] is missing"),
    ],
)
def test_residuals_that_are_none_are_refused(calibrated: Desk, desk: Desk, spoil, message: str):
    folder = desk.folder / "result"
    folder.mkdir()
    for name in RESULT_FILES[:-1]:
        (folder / name).write_bytes((calibrated.folder / "result" / name).read_bytes())
    path = folder / "residuals.csv"
    path.write_text(spoil(path.read_text()))
    [fault] = desk.refused("report result")
    assert fault.startswith("result/residuals.csv: not the residuals that a calibration wrote: ")
    assert message in fault


def test_what_report_refuses(calibrated: Desk, desk: Desk):
    [none] = desk.refused("report")
    assert none == "expected the folder of a calibration (calibrate -o DIR), or several to compare; found none"
    [missing] = desk.refused("report nowhere")
    assert missing == "nowhere: not the folder of a calibration (calibrate -o DIR): there is no result.json"
    [over] = calibrated.refused("report result -o result/result.json")
    assert over.startswith("result/result.json is an input")


@pytest.mark.parametrize("count", [2, MOST_SHOWN, MOST_SHOWN + 1, 300])
def test_covariances_are_read_as_they_were_written(count: int):
    rng = np.random.default_rng(count)
    half = rng.normal(size=(count, count)) * np.exp(rng.normal(size=count) * 10.0)
    covariance = half @ half.T
    covariance = 0.5 * (covariance + covariance.T)
    table = json.loads(json.dumps(covariance_table([f"p{i}" for i in range(count)], covariance)))
    assert np.array_equal(covariance_from(table), covariance)
    assert ("matrix" in table) == (count <= MOST_SHOWN)


def test_a_packed_covariance_that_was_cut_is_refused():
    table = covariance_table([f"p{i}" for i in range(200)], np.eye(200))
    with pytest.raises(ValueError, match="expected the lower triangle of 200 rows, found 20097 numbers"):
        covariance_from(table | {"lower": table["lower"][:-32]})


def test_wrenches_and_distances_survive():
    rng = np.random.default_rng(4)
    actual = placed(arm(), rng, offset=0.1)
    data = measured(actual, 50, 3, noise=1e-5)
    data = replace(data, wrench=rng.normal(size=(50, 6)))
    saved = as_saved(ec.calibrate(arm(), data))
    assert saved.errors is not None
    assert saved.errors.data.wrench == pytest.approx(data.wrench, abs=1e-8)
    guess = replace(actual, base=replace(actual.base, known=False), tool=replace(actual.tool, known=False))
    distances = measured(actual, 80, 3, noise=1e-5, kinds=("distance",))
    result = ec.calibrate(guess, distances)
    again = as_saved(result)
    assert again.errors is not None
    assert again.errors.calibrated.distance == pytest.approx(result.errors.calibrated.distance, abs=1e-11)
    assert "Error vectors" in [section.title for section in report_sections(again)]


def test_signs_stand_for_verdicts_beside_colours():
    assert {"identified", "insignificant", "dependent", "unobservable", "fixed"} <= CELLS.keys()
    assert all(sign for name, (kind, sign) in CELLS.items() if kind)


def test_several_results_side_by_side(desk: Desk):
    save_simulated(desk.folder)
    for name, elastic in (("rigid", ""), ("linear", "--elastic 2,3"), ("step", "--elastic 2:step,3")):
        desk.done(f"calibrate robot.toml fit.csv --held-out held_out.csv {elastic} -o runs/{name}")
    printed = desk.done("report runs/rigid runs/linear runs/step")
    assert max(map(len, printed.splitlines())) <= 80
    assert "has the least mean error on held-out rows" in " ".join(printed.split())
    assert "what differs is the model" in " ".join(printed.split())
    before = contents(desk.folder)
    ran = desk.run("report runs/rigid runs/linear runs/step -o compared.html")
    assert ran.err == "compared.html\n"
    page = (desk.folder / "compared.html").read_text(encoding="utf-8")
    for part in ("From rigid to linear", "2.theta.c_low", "3 calibrations side by side", "Position error after"):
        assert part in page
    assert {k: v for k, v in contents(desk.folder).items() if k != "compared.html"} == before


def test_diff_and_compare_write_pages_of_what_they_print(desk: Desk):
    save_simulated(desk.folder)
    for name in ("one", "two"):
        desk.done(f"calibrate robot.toml {'fit' if name == 'one' else 'held_out'}.csv --elastic 2,3 -o {name}")
    printed = desk.done("diff one two --html changes.html")
    page = (desk.folder / "changes.html").read_text(encoding="utf-8")
    assert "changes between two calibrations" in printed
    assert page.count("<tr>") > 20
    desk.done("compare robot.toml fit.csv --elastic 2,3 --models rigid,linear --folds 2 --html models.html")
    assert "criterion" in (desk.folder / "models.html").read_text(encoding="utf-8")
    [fault] = desk.refused("diff one two --html one/result.json")
    assert "is an input" in fault
    [fault] = desk.refused("compare robot.toml fit.csv --elastic 2 --html fit.csv")
    assert fault == "fit.csv is an input, which a result never overwrites: choose another place (-o)"


def test_folders_of_one_name_are_told_apart():
    from elastocal.report.results import named_results

    found = named_results(["may/result", "./june/result/"], [None, None])
    assert list(found) == ["may/result", "june/result"]
    assert list(named_results(["a", "a"], [None, None])) == ["a (1)", "a (2)"]


def test_results_that_have_no_rows_can_be_compared(calibrated: Desk, desk: Desk):
    for name in ("one", "two"):
        (desk.folder / name).mkdir()
        for file in ("robot.toml", "result.json"):
            Path(desk.folder / name / file).write_bytes((calibrated.folder / "result" / file).read_bytes())
    assert "what differs is the model" in " ".join(desk.done("report one two").split())
