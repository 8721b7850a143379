"""What the page refuses: other hosts and origins, large bodies, files that were not given to it."""

from __future__ import annotations

import asyncio
import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from elastocal.errors import InputError
from elastocal.web import create_app
from elastocal.web.security import MOST_FORM, MOST_UPLOAD
from elastocal.web.uploads import MOST_FILES, MOST_NAME, safe_name
from support.files import DESCRIPTOR, ROBOT, TABLE, TRACKER, URDF, contents, edited
from support.web import ORIGIN, PORT, SETTINGS, Page, page, simulated_files

__all__ = ["page"]


@pytest.mark.parametrize(
    "host", ["evil.example", f"evil.example:{PORT}", f"127.0.0.1.evil.example:{PORT}", "127.0.0.1:1", "127.0.0.1", ""]
)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_another_name_of_this_computer_is_refused(page: Page, method: str, host: str):
    got = page.client.request(method, "/", headers={"host": host, "origin": f"http://{host}"})
    assert got.status_code == 400
    assert "on this computer only" in got.text


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost"])
def test_both_names_of_this_computer_are_its_own(page: Page, host: str):
    named = {"host": f"{host}:{PORT}", "origin": f"http://{host}:{PORT}"}
    assert page.client.get("/", headers=named).status_code == 200
    assert page.client.post("/runs", headers=named).status_code == 201


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": f"https://127.0.0.1:{PORT}"},
        {"origin": "http://127.0.0.1:8000"},
        {"origin": f"http://localhost:{PORT}"},
        {"origin": ORIGIN, "sec-fetch-site": "cross-site"},
        {"origin": ORIGIN, "sec-fetch-site": "same-site"},
        {"sec-fetch-site": "none"},
        {},
    ],
)
def test_a_change_that_another_origin_asks_for_is_refused(page: Page, headers: dict[str, str]):
    run = page.new({"robot.toml": ROBOT})
    before = contents(page.folder)
    page.client.headers.pop("origin")
    for method, address in (
        ("POST", "/runs"),
        ("POST", "/runs/example"),
        ("PUT", f"{run}/files/fit.csv"),
        ("POST", f"{run}/start"),
        ("POST", f"{run}/delete"),
    ):
        got = page.client.request(method, address, headers=headers, content=b"x")
        assert got.status_code == 403, address
        assert "another origin" in got.text
    assert contents(page.folder) == before


def test_another_site_reads_nothing_but_may_lead_here(page: Page):
    page.client.headers.pop("origin")
    foreign = {"sec-fetch-site": "cross-site"}
    for mode, dest in (("no-cors", "script"), ("cors", "empty"), ("navigate", "iframe"), ("no-cors", "image")):
        got = page.client.get("/", headers=foreign | {"sec-fetch-mode": mode, "sec-fetch-dest": dest})
        assert got.status_code == 403
    link = foreign | {"sec-fetch-mode": "navigate", "sec-fetch-dest": "document"}
    assert page.client.get("/", headers=link).status_code == 200
    assert page.client.get("/", headers={"origin": "http://evil.example"}).status_code == 403


def test_every_answer_lets_in_scripts_of_this_page_only(page: Page):
    run = page.new()
    addresses = ("/", run, "/nothing", "/static/page.css", "/plotly.min.js", "/runs/../../etc/passwd", "/compare")
    for address in addresses:
        got = page.client.get(address)
        policy = dict(part.split(maxsplit=1) for part in got.headers["content-security-policy"].split("; "))
        assert policy["default-src"] == "'none'"
        assert policy["script-src"] == policy["connect-src"] == "'self'"
        assert policy["frame-ancestors"] == "'none'"
        assert got.headers["x-content-type-options"] == "nosniff"
    refused = page.client.get("/", headers={"host": "evil.example"})
    assert "content-security-policy" in refused.headers


def test_no_page_has_scripts_of_its_own(page: Page, tmp_path: Path):
    run = page.new(simulated_files(tmp_path / "files"))
    for address in ("/", run, "/compare"):
        text = page.text(address)
        assert not re.search(r"<script(?![^>]*\bsrc=)", text)
        assert not re.search(r"\son\w+=", text)
        assert not re.search(r"""(?:src|href|action)=["']?(?:https?:)?//""", text)


def test_a_gigabyte_is_refused_before_it_is_read(page: Page):
    run = page.new()
    got = page.client.put(f"{run}/files/big.csv", content=b"", headers={"content-length": str(2**30)})
    assert got.status_code == 413
    assert "200 MB at most" in got.text
    assert list((page.run_folder(run) / "inputs").iterdir()) == []


def test_a_gigabyte_that_does_not_say_so_is_refused_on_the_way(page: Page):
    """Sent in pieces without a length: no more than the limit is taken, and nothing is left of it."""
    run, piece = page.new(), bytes(2**22)
    sent = 0

    async def receive() -> dict[str, object]:
        nonlocal sent
        sent += len(piece)
        return {"type": "http.request", "body": piece, "more_body": sent < 2**30}

    answers: list[dict[str, object]] = []

    async def send(message: dict[str, object]) -> None:
        answers.append(message)

    address = f"{run}/files/big.csv"
    headers = [(b"host", f"127.0.0.1:{PORT}".encode()), (b"origin", ORIGIN.encode())]
    scope = {"type": "http", "method": "PUT", "path": address, "raw_path": address.encode(), "query_string": b""}
    scope |= {"headers": headers, "server": ("127.0.0.1", PORT), "scheme": "http", "root_path": ""}
    with ThreadPoolExecutor(1) as thread:  # in this one the browser of other tests has its loop
        thread.submit(lambda: asyncio.run(create_app(page.folder)(scope, receive, send))).result()
    assert answers[0]["status"] == 413
    assert sent <= MOST_UPLOAD + 2 * len(piece)
    assert [path for path in page.run_folder(run).rglob("*") if path.is_file()] == [
        page.run_folder(run) / "settings.json"
    ]


def test_forms_are_bounded_too(page: Page):
    run = page.new()
    got = page.client.post(f"{run}/settings", content=b"x" * (MOST_FORM + 1))
    assert got.status_code == 413
    assert page.client.post(f"{run}/settings", content=b"", headers={"content-length": "-1"}).status_code == 400


def test_a_run_has_a_bounded_number_of_files(page: Page):
    run = page.new()
    for i in range(MOST_FILES):
        (page.run_folder(run) / "inputs" / f"{i}.csv").write_text("")
    got = page.upload(run, "one-more.csv", TABLE)
    assert got.status_code == 422
    assert f"{MOST_FILES} files at most" in got.text
    assert page.upload(run, "7.csv", TABLE).status_code == 201


@pytest.mark.parametrize(
    ("name", "safe"),
    [
        ("fit.csv", "fit.csv"),
        ("mesure n° 3 (été).csv", "mesure n_ 3 (été).csv"),
        ("../../etc/passwd", "passwd"),
        ("C:\\data\\fit.csv", "fit.csv"),
        (".bashrc", "_bashrc"),
        ("-o.csv", "_o.csv"),
        ("<script>alert(1)</script>.csv", "script_.csv"),
        ("a\nb\x00.csv", "a_b_.csv"),
        ("fit.csv;rm -rf", "fit.csv_rm -rf"),
    ],
)
def test_names_are_made_harmless(name: str, safe: str):
    assert safe_name(name) == safe


@pytest.mark.parametrize("name", ["", "..", "/", ".", "a/..", "___", "x" * (MOST_NAME + 1)])
def test_names_of_nothing_are_refused(name: str):
    with pytest.raises(InputError, match=r"name"):
        safe_name(name)


@pytest.mark.parametrize(
    "file", ["/etc/passwd", "../settings.json", "..\\\\settings.json", "a/b.csv", "C:\\\\fit.csv", "..", ""]
)
def test_a_descriptor_reads_no_file_that_was_not_given(page: Page, file: str):
    run = page.new({"robot.toml": ROBOT, "tracker.csv": TRACKER})
    page.upload(run, "tracker.toml", edited(DESCRIPTOR, ('"tracker.csv"', f'"{file}"')))
    text = page.text(run)
    assert "<b>file</b> expected the name of a file given with it" in text
    assert page.client.post(f"{run}/start").status_code == 409


def test_a_descriptor_reads_no_link_to_another_file(page: Page, tmp_path: Path):
    (tmp_path / "secret.csv").write_text(TRACKER)
    run = page.new({"robot.toml": ROBOT, "tracker.toml": DESCRIPTOR})
    (page.run_folder(run) / "inputs" / "tracker.csv").symlink_to(tmp_path / "secret.csv")
    assert "no other file is read" in page.text(run)


@pytest.mark.parametrize(
    "address",
    [
        "/runs/%2e%2e",
        "/runs/%2e%2e%2f%2e%2e",
        "/runs/%2e",
        "/runs/20260101-000000-abcdef",
        "/static/%2e%2e/app.py",
        "/static/../app.py",
        "{run}/download/%2e%2e%2fsettings.json",
        "{run}/download/settings.json",
        "{run}/download/%2e%2e",
        "{run}/report",
        "/docs",
        "/openapi.json",
    ],
)
def test_nothing_else_of_this_computer_can_be_had(page: Page, address: str):
    run = page.new({"robot.toml": ROBOT})
    assert page.client.get(address.format(run=run)).status_code == 404


def test_a_link_among_the_runs_is_none(page: Page, tmp_path: Path):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "settings.json").write_text("{}")
    page.new()
    (page.folder / "20260101-000000-abcdef").symlink_to(elsewhere)
    assert page.client.get("/runs/20260101-000000-abcdef").status_code == 404


def test_names_are_shown_to_the_letter(page: Page):
    hostile = "<script>alert(1)</script>"
    robot = edited(ROBOT, ('"arm"', f'"{hostile}"'), ('name = "elbow"', 'name = "<b>elbow"'))
    run = page.new({"robot.toml": robot, "fit.csv": edited(TABLE, ("x [mm]", "x [<img src=x>]"))})
    page.client.post(f"{run}/settings", data=SETTINGS | {"name": hostile})
    for address in (run, "/"):
        text = page.text(address)
        assert "<script>alert" not in text
        assert "<b>elbow" not in text
        assert "<img src=x" not in text
    assert "&lt;script&gt;alert(1)" in page.text(run)


def test_entities_of_a_urdf_are_not_expanded(page: Page):
    grown = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 9))
    for entities in (grown, '<!ENTITY a8 SYSTEM "file:///etc/passwd">'):
        bomb = f'<!DOCTYPE robot [<!ENTITY a0 "lol">{entities}]>' + edited(URDF, ('name="u"', 'name="&a8;"'))
        run = page.new({"robot.urdf": bomb})
        text = page.text(run)
        assert "expected no entities" in text
        assert "lollol" not in text


def test_a_file_nested_without_end_is_a_fault(page: Page):
    run = page.new({"robot.toml": "a = " + "[" * 100_000})
    assert "nested too deeply" in page.text(run)


def test_an_uploaded_module_is_never_imported(page: Page, tmp_path: Path):
    """The command runs in the folder of the user's files."""
    marker = tmp_path / "ran"
    module = f"from pathlib import Path\nPath({str(marker)!r}).write_text('')\n"
    names = ("numpy.py", "elastocal.py", "sitecustomize.py", "tomllib.py")
    run = page.new(simulated_files(tmp_path / "files") | dict.fromkeys(names, module))
    page.do(f"{run}/roles", **{f"role {name}": "unused" for name in names})
    page.do(f"{run}/start", **SETTINGS)
    assert "mm" in page.finished(run)
    assert not marker.exists()
