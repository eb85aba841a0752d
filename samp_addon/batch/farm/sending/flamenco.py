"""Submits a job to Flamenco's manager by its HTTP API (version 3)."""

from __future__ import annotations

import json
import urllib.error
import urllib.parse
import urllib.request
from typing import Any

from ....errors import SampError

TIMEOUT = 20.0  # seconds
UNKNOWN_TYPE = 404


def check(manager: str) -> None:
    """Raise SampError for an address that is none of a manager."""
    found = urllib.parse.urlsplit(manager)
    if found.scheme not in ("http", "https") or not found.netloc:
        raise SampError(
            f"'{manager}' is no address of a Flamenco manager; write one such as http://farm:8080."
        )


def post(manager: str, job: dict[str, Any]) -> str:
    """Submit a job; return the id that the manager gives it. Raise SampError where it is not taken.

    The job type's etag is asked for first: with it, the manager refuses a job for another version of the script.
    """
    check(manager)
    base = manager.rstrip("/") + "/api/v3/jobs"
    try:
        kind = _answer(urllib.request.Request(f"{base}/type/{job['type']}"))
    except urllib.error.HTTPError as error:
        if error.code == UNKNOWN_TYPE:
            raise SampError(
                f"Flamenco has no job type '{job['type']}'; copy farm/flamenco/samp_bake.js into its scripts folder."
            ) from error
        raise _refused(manager, error) from error
    except (OSError, ValueError) as error:
        raise _unreachable(manager, error) from error
    etag = {"type_etag": kind["etag"]} if kind.get("etag") else {}
    body = json.dumps(job | etag).encode()
    request = urllib.request.Request(base, body, {"Content-Type": "application/json"}, method="POST")
    try:
        return str(_answer(request).get("id", ""))
    except urllib.error.HTTPError as error:
        raise _refused(manager, error) from error
    except (OSError, ValueError) as error:
        raise _unreachable(manager, error) from error


def _answer(request: urllib.request.Request) -> dict[str, Any]:
    """Return the JSON object that the manager answers."""
    with urllib.request.urlopen(request, timeout=TIMEOUT) as response:
        found = json.loads(response.read().decode("utf-8"))
    if not isinstance(found, dict):
        raise ValueError("the answer is no JSON object")
    return found


def _refused(manager: str, error: urllib.error.HTTPError) -> SampError:
    try:
        said = json.loads(error.read().decode("utf-8")).get("message", "")
    except (OSError, ValueError, AttributeError):
        said = ""
    return SampError(f"Flamenco at {manager} refused the job ({error.code}{': ' + said if said else ''}).")


def _unreachable(manager: str, error: Exception) -> SampError:
    reason = getattr(error, "reason", None) or error
    return SampError(
        f"Flamenco at {manager} cannot be reached ({reason}); check its address in the preferences."
    )
