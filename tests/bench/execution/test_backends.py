import threading

from bench.execution.backends import open_pool


def test_threads_that_feed_workers_have_ended_when_the_pool_has():
    """One that is cut off at the end of the process leaks a semaphore, of which Python complains on the screen."""
    joined = threading.Event()

    class Feeder(threading.Thread):
        def join(self, timeout=None):
            joined.set()
            super().join(timeout)

    feeder = Feeder(target=joined.wait, name="QueueFeederThread", daemon=True)
    with open_pool("loky", 2, None):
        feeder.start()
    assert not feeder.is_alive()
