"""The page of `mat report` in a browser: no error on its console, nothing asked of the network."""

import json
import shutil
import subprocess
import sys
from urllib.parse import urlsplit

import pytest

from skyshine.mat.builder.build import build
from skyshine.mat.job.load import load_job

pytestmark = pytest.mark.validation
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
BROWSERS_OWN = (".google.com", ".googleapis.com")  # updates and clock of the browser itself, whatever it shows


def test_page_in_a_browser(tmp_path):
    browser = shutil.which("chromium") or shutil.which("chromium-browser")
    if browser is None:
        pytest.skip("chromium is not installed")
    command = [sys.executable, "-c", "from skyshine.mat.cli import main; main()"]
    subprocess.run([*command, "init", str(tmp_path / "demo")], check=True)
    job = tmp_path / "demo" / "job.yaml"
    build(load_job(job), jobs=2)
    page, log = tmp_path / "report.html", tmp_path / "net.json"
    subprocess.run(
        [*command, "report", str(job), "--band", "b02", "--scenes", "4", "--out", str(page)], check=True, timeout=300
    )
    done = subprocess.run(
        [
            browser,
            *FLAGS,
            f"--user-data-dir={tmp_path / 'profile'}",
            f"--log-net-log={log}",
            "--enable-logging=stderr",
            "--dump-dom",
            page.as_uri(),
        ],
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert "Error budget: yellowstone" in done.stdout and "<svg" in done.stdout
    assert "CONSOLE" not in done.stderr, done.stderr
    outside = {urlsplit(url) for url in _urls(json.loads(log.read_text(encoding="utf-8")))}
    asked = {
        url
        for url in outside
        if url.scheme != "file" and not url.netloc.endswith(BROWSERS_OWN) and url.scheme != "data"
    }
    assert not asked, asked


def _urls(log: dict) -> list[str]:
    """Addresses of the requests that a network log of the page holds."""
    kinds = {number: name for name, number in log["constants"]["logEventTypes"].items()}
    return [
        event["params"]["url"]
        for event in log["events"]
        if kinds.get(event["type"]) == "URL_REQUEST_START_JOB" and "url" in event.get("params", {})
    ]
