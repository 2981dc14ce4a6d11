/* Pipeline::stop() with draining: door, done flag, doorbell and ring together. A producer that
 * pushes until it is refused, one thread that stops, a consumer that goes on until it has seen
 * the end. Steps as in pipeline.cpp, live_run.cpp, consumer_loop.cpp; no deadline.
 *
 * Each of these mutants must be refuted:
 *   -DCLOSED_BEFORE_DOOR   the done flag is set while a producer may be inside
 *   -DDOOR_WITHOUT_WAIT    the door does not wait for the one inside
 *   -DDONE_AFTER_INDEX     the consumer asks whether it is done after its last look at the index
 *   -DWAKE_SKIPPED         stop() does not ring
 *   -DREADY_WITHOUT_CLOSED the look before sleep is not at the done flag
 */
#ifndef TOTAL
#define TOTAL 3
#endif

byte tail, head, wanted;
bool open = true, inside, closed;
bool asleep, sleeping;

inline exchange_asleep(before, value) { d_step { before = asleep; asleep = value } }
inline wake(was) {
  exchange_asleep(was, false);
  if
  :: was -> sleeping = false
  :: else
  fi
}

active proctype producer() {
  bool was_open, was;
  do
  :: tail < TOTAL ->
    d_step { was_open = open; inside = true }
    if
    :: !was_open -> inside = false; break
    :: else
    fi;
    assert(!closed);
    tail++;
    assert(!closed);    /* nothing is pushed after the end */
    was = asleep;
    if
    :: was && tail >= wanted -> wake(was)
    :: else
    fi;
    inside = false
  :: else -> break
  od
}

active proctype stopper() {
  bool was;
#ifdef CLOSED_BEFORE_DOOR
  closed = true;
#endif
  open = false;
#ifndef DOOR_WITHOUT_WAIT
  !inside;
#endif
  closed = true;
#ifndef WAKE_SKIPPED
  wake(was);
#endif
}

active proctype consumer() {
  bool done, ready, was;
  do
  :: true ->
#ifdef DONE_AFTER_INDEX
    ready = tail > head;
    done = closed;
#else
    done = closed;
    ready = tail > head;
#endif
    if
    :: ready -> head++
    :: !ready && done -> break
    :: else ->
      wanted = head + 1;
      exchange_asleep(was, true);
      ready = tail >= wanted;
#ifndef READY_WITHOUT_CLOSED
      ready = ready || closed != done;
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
      exchange_asleep(was, false)
    fi;
    ready = false; done = false
  od;
  (inside == false && open == false);
  assert(head == tail)  /* drained */
}
