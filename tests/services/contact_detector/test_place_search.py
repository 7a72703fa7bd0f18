"""Places are searched beside the detection, and what is no longer wanted is dropped."""

import threading

import pytest

from bus.testing import eventually
from estimation.contact.localisation import Localisation
from estimation.contact.touch_map import NO_MAP
from services.contact_detector.place_search import NOTHING, Found, PlaceSearch

FOUND = Found(Localisation((), 0.5), NO_MAP)


def test_the_search_is_waited_for_by_nobody_and_its_result_is_taken_later():
    go, search = threading.Event(), PlaceSearch(beside=True)
    search.begin(lambda: FOUND if go.wait(10.0) else NOTHING)
    assert not search.idle and search.found is NOTHING
    go.set()
    eventually(lambda: search.idle, 60.0, "the search ended")
    assert search.found is FOUND


def test_a_touch_that_ended_meanwhile_is_nowhere():
    go, search = threading.Event(), PlaceSearch(beside=True)
    search.begin(lambda: FOUND if go.wait(10.0) else NOTHING)
    search.forget()
    go.set()
    eventually(lambda: search.idle, 60.0, "the search ended")
    assert search.found is NOTHING


def test_where_runs_must_repeat_the_result_is_there_at_once():
    search = PlaceSearch(beside=False)
    search.begin(lambda: FOUND)
    assert search.idle and search.found is FOUND


def test_an_error_of_the_search_is_not_lost():
    search = PlaceSearch(beside=True)
    search.begin(lambda: FOUND._replace(nowhere=1))
    with pytest.raises(ValueError):
        eventually(lambda: search.idle, 60.0, "the search ended")
