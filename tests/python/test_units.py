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


@pytest.mark.parametrize("text", ["10", "10.5", "1e4", " 10 "])
def test_a_bare_number_is_refused_and_the_remedy_shows_a_unit(text):
    with pytest.raises(ValueError, match=r"latency = .*the unit is missing, for example .*ms"):
        _units.parse_duration_us(text, field="latency")


@pytest.mark.parametrize(
    "text", ["", "ms", "ten ms", "10 parsecs", "10MS", "-1ms", "nan ms", "1e999s", "10ms5", "1+1ms"]
)
def test_what_is_no_duration_names_field_and_value(text):
    with pytest.raises(ValueError, match=r"^latency = ") as error:
        _units.parse_duration_us(text, field="latency")
    assert f"latency = {text}:" in str(error.value)


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


@pytest.mark.parametrize("text", ["100us", "100+300", "100us+300", "100us+300ns+1ns", "us+ns", ""])
def test_what_is_no_cost_is_refused(text):
    with pytest.raises(ValueError, match=r"^cost"):
        _units.parse_cost(text)


@given(st.integers(0, 10**12))
def test_whole_microseconds_survive(us):
    assert _units.parse_duration_us(f"{us}us") == us


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


@given(WORDS, WORDS)
def test_any_text_is_a_finite_cost_or_refused_by_name(alpha, beta):
    try:
        cost = _units.parse_cost(f"{alpha}+{beta}")
    except ValueError as error:
        assert str(error).startswith("cost")
    else:
        assert all(0 <= value < float("inf") for value in cost)


@pytest.mark.parametrize(
    ("us", "text"),
    [
        (0, "0 us"),
        (0.3, "300 ns"),
        (4.2, "4.2 us"),
        (999.96, "1 ms"),
        (4_213, "4.21 ms"),
        (-4_213, "-4.21 ms"),
        (10_000, "10 ms"),
        (123_456, "123 ms"),
        (4e9, "4,000 s"),
        (5e6, "5 s"),
    ],
)
def test_durations_are_written_with_three_digits(us, text):
    assert _units.duration(us) == text


@pytest.mark.parametrize(
    ("hz", "text"),
    [(0, "0 ev/s"), (950, "950 ev/s"), (6.53e6, "6.53 Mev/s"), (999_900, "1 Mev/s")],
)
def test_rates_are_written_with_three_digits(hz, text):
    assert _units.rate(hz) == text


def test_shares_never_round_to_none_or_all():
    assert _units.share(0) == "0.0 %"
    assert _units.share(1) == "100.0 %"
    assert _units.share(1e-9) == "< 0.1 %"
    assert _units.share(1 - 1e-9) == _units.share(0.9992) == "> 99.9 %"
    assert _units.share(0.1234) == "12.3 %"


def test_counts_are_grouped():
    assert _units.count(27_300_000) == "27,300,000"


def test_a_number_stays_with_its_sign_and_unit_at_every_width():
    for width in range(9, 40):
        lines = _units.wrapped("5 ms per package, +- 10 % of it", width)
        assert any("+- 10 %" in line for line in lines)
