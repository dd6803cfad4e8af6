"""What the tests of boards share."""
import concurrent.futures

import pytest

AT_ONCE = 3


@pytest.fixture(scope="module")
def results(request, tmp_path_factory):
    """Runs the CASES of a file, some at a time: boards mostly wait. CASES: a function and its arguments by
    name. The function gets a folder of its own first.

    @returns their futures by name"""
    with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
        yield {
            name: pool.submit(function, tmp_path_factory.mktemp("case"), *arguments)
            for name, (function, *arguments) in request.module.CASES.items()
        }
