"""Targets for text: set-ups in TOML, and the input files of SIANS and GUBAS."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import fullbody
from fullbody.setups import toml as toml_setup
from hypothesis import strategies as st

from .target import CORPUS, Target, check_finite, check_start, file_target

_PEERS = Path(__file__).parents[2] / "tests" / "data" / "peers"
_WORD = re.compile(r"[^\s,\[\]{}=:#\"]+")
#: Replacements of words.
_NUMBERS = [
    *("0", "-0.0", "-1", "1e308", "-1e308", "5e-324", "1e-200", "1e999", "nan", "-inf", "1_0", "0x10", "1e", "."),
    *("1" + "0" * 400, "9" * 5000, "0." + "1" * 400, "1/0", "1/2", "2*pi", "pi*1e999", "(((1)))", "１２", "+", "1e5"),
]
_TOML = [
    *('"1 km"', '"3 deg"', '"nan s"', '"1e400 m"', '"1 furlong"', '"km"', '""', "'2 h'", '"1 d2"', '"50 %"', '"1 mag"'),
    *("true", "[]", "{}", "[[1]]", "[1, 2, 3]", "[0, 0, 0]", "[0, 0, 0, 0]", '["km", "hour", "kg"]', '["s", "s", "s"]'),
    *("1979-05-27", "07:32:00", "[" * 200, "{a=" * 200, '"focal"', '"multipole:4"', '"multipole:99"', '"Alpha"', "#"),
    *('"LieGroupVariational"', '"SymplecticSplitting"', "step", "[body]", "[[system]]", "[run.until]", '"\\u0000"'),
]


@st.composite
def _edited(draw: Any, originals: list[str], words: list[str]) -> bytes:
    """Return a strategy of one of some texts after a few edits."""
    text = draw(st.sampled_from(originals))
    for _ in range(draw(st.integers(1, 5))):
        lines = text.splitlines() or [""]
        line = draw(st.integers(0, len(lines) - 1))
        match draw(st.sampled_from(["word", "word", "word", "word", "swap", "drop", "double", "cut", "insert"])):
            case "word":
                matches = list(_WORD.finditer(text))
                if matches:
                    word = draw(st.sampled_from(matches))
                    text = text[: word.start()] + draw(st.sampled_from(words)) + text[word.end() :]
                continue
            case "cut":
                text = text[: draw(st.integers(0, len(text)))]
                continue
            case "insert":
                at = draw(st.integers(0, len(text)))
                text = text[:at] + draw(st.text(max_size=3)) + text[at:]
                continue
            case "swap":
                other = draw(st.integers(0, len(lines) - 1))
                lines[line], lines[other] = lines[other], lines[line]
            case "drop":
                del lines[line]
            case "double":
                lines.insert(draw(st.integers(0, len(lines))), lines[line])
        text = "\n".join(lines)
    data = bytearray(text.encode(errors="surrogatepass"))
    if data and draw(st.integers(0, 9)) == 0:
        data[draw(st.integers(0, len(data) - 1))] = draw(st.integers(0, 255))
    return bytes(data)


def _texts(*paths: Path) -> list[str]:
    return [path.read_text() for path in paths]


def _example() -> str:
    """Return the setup in the documentation of the format."""
    block = (toml_setup.__doc__ or "").partition(".. code-block:: toml\n")[2]
    return "\n".join(line.removeprefix("    ") for line in block.splitlines())


def _read_toml(path: Path) -> None:
    setup = fullbody.read_toml(path)
    check_finite(setup.until, *([] if setup.output is None else [setup.output]))
    check_start(setup.system, setup.state)
    assert repr(setup)


def _read_sians(path: Path) -> None:
    check_start(*fullbody.read_sians(path))
    check_start(*fullbody.read_sians(path, units="kmhr"))


def _read_gubas(path: Path) -> None:
    check_start(*fullbody.read_gubas(path))


TARGETS: list[Target] = [
    file_target(
        "toml",
        ".toml",
        _edited([_example(), *_texts(*sorted((CORPUS / "toml").glob("[!f]*.toml")))], [*_TOML, *_NUMBERS]),
        _read_toml,
    ),
    file_target(
        "sians", ".txt", _edited(_texts(*sorted(_PEERS.glob("sians*"))), [*_NUMBERS, "@", "sun:"]), _read_sians
    ),
    file_target("gubas", ".cfg", _edited(_texts(*sorted(_PEERS.glob("*.cfg"))), [*_NUMBERS, "[a]", ";"]), _read_gubas),
]
