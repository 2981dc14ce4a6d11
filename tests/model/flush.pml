/* Flush: what waits now is due, whatever the scheme waits for. The scheme here waits for ever, so
 * only flushes move events; the consumer must deliver up to the index of each, sleep or not, while
 * the producer goes on and another thread flushes too. consumer_loop.cpp and doorbell.hpp, no
 * deadline: what is not flushed is a deadlock.
 *
 * Each of these mutants must be refuted:
 *   -DWAKE_SKIPPED         flush() does not ring
 *   -DWAKE_BEFORE_INDEX    it rings, then says what is due
 *   -DFLUSH_GOES_BACK      an older flush takes the place of a newer one
 *   -DREADY_WITHOUT_FLUSH  the look before sleep is not at the flush index
 *   -DASLEEP_AFTER_CHECK   the consumer looks once more before it says that it sleeps
 *   -DFLUSH_READ_LATE      what has been asked is read again after the look at the ring
 */
#ifndef TOTAL
#define TOTAL 3
#endif

byte tail, head, due;
bool asleep, sleeping, finished;

inline exchange_asleep(before, value) { d_step { before = asleep; asleep = value } }
inline wake(was) {
  exchange_asleep(was, false);
  if
  :: was -> sleeping = false
  :: else
  fi
}

/* Pushes; its announce() never rings, because the tail that is wanted is never reached. */
active proctype producer() {
  do
  :: tail < TOTAL -> tail++
  :: else -> break
  od;
  finished = true
}

inline raise_due() {
#ifdef FLUSH_GOES_BACK
  due = index
#else
  d_step {
    if
    :: due < index -> due = index
    :: else
    fi
  }
#endif
}

inline flush() {
  index = tail;
#ifdef WAKE_BEFORE_INDEX
  wake(was);
  raise_due();
#else
  raise_due();
#ifndef WAKE_SKIPPED
  wake(was);
#endif
#endif
  head >= index         /* delivered: this is what flush() promises */
}

active proctype once() {
  byte index;
  bool was;
  flush()
}

active proctype flusher() {
  byte index;
  bool was, last;
  do
  :: true ->
    last = finished;
    flush();
    if
    :: last -> break
    :: else
    fi
  od
}

active proctype consumer() {
  byte seen;
  bool ready, was;
  do
  :: true ->
    seen = due;
    if
    :: seen > head -> head = seen
    :: else
    fi;
#ifdef FLUSH_READ_LATE
    seen = due;
#endif
    if
    :: head == TOTAL -> break
    :: else
    fi;
#ifdef ASLEEP_AFTER_CHECK
    ready = due != seen;
#endif
    exchange_asleep(was, true);
#ifdef READY_WITHOUT_FLUSH
    ready = false;
#else
#ifndef ASLEEP_AFTER_CHECK
    ready = due != seen;
#endif
#endif
    if
    :: ready
    :: else ->
      d_step {
        if
        :: asleep -> sleeping = true
        :: else
        fi
      };
      !sleeping
    fi;
    exchange_asleep(was, false);
    ready = false
  od
}
