import pytest
from hypothesis import given
from hypothesis import strategies as st

from asap import _units


@pytest.mark.parametrize(
    ("text", "us"),
    [
        ("10ms", 10_000.0),
        ("10 ms", 10_000.0),
        (" 0.5ms ", 500.0),
        ("250us", 250.0),
        ("250µs", 250.0),
        ("300ns", 0.3),
        ("1s", 1e6),
        ("1e-3s", 1e3),
        ("1e3us", 1e3),
        (".5s", 5e5),
        ("0ms", 0.0),
    ],
)
def test_duration_in_any_unit(text, us):
    assert _units.parse_duration_us(text) == us


@pytest.mark.parametrize(
    ("text", "cost"),
    [
        ("100us+300ns", (100.0, 300.0)),
        ("100us + 300ns", (100.0, 300.0)),
        ("0us+0.3us", (0.0, 300.0)),
        ("1e+2us+3e+2ns", (100.0, 300.0)),
        ("0.1ms+150ns", (100.0, 150.0)),
    ],
)
def test_cost_per_package_and_per_event(text, cost):
    assert _units.parse_cost(text) == cost


WORDS = st.lists(
    st.one_of(
        st.sampled_from(("ms", "us", "µs", "ns", "s", "+", "-", "e", ".", "1e400", "inf", "nan")),
        st.sampled_from((" ", "_", "\n", "\u0661", "9" * 400)),
        st.integers(0, 10**6).map(str),
        st.characters(),
    ),
    max_size=6,
).map("".join)


@given(WORDS)
def test_any_text_is_a_finite_duration_or_refused_by_name(text):
    try:
        us = _units.parse_duration_us(text, field="latency")
    except ValueError as error:
        assert str(error).startswith("latency = ")
    else:
        assert 0 <= us < float("inf")


def test_shares_never_round_to_none_or_all():
    assert _units.share(0) == "0.0 %"
    assert _units.share(1) == "100.0 %"
    assert _units.share(1e-9) == "< 0.1 %"
    assert _units.share(1 - 1e-9) == _units.share(0.9992) == "> 99.9 %"
    assert _units.share(0.1234) == "12.3 %"
