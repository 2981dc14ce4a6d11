/* Pipeline::stop() with draining: door, done flag, doorbell and ring together. A producer that
 * pushes until it is refused, one thread that stops, a consumer that goes on until it has seen
 * the end; who stops, or the last push, says it. Steps as in pipeline.cpp,
 * consumer_loop.cpp; no deadline.
 *
 * Each of these mutants must be refuted:
 *   -DCLOSED_BEFORE_DOOR   the done flag is set while a producer may be inside
 *   -DLAST_OUT_IS_SILENT   the push that was inside does not set the done flag
 *   -DWHO_STOPS_SAYS_IT    stop() sets the done flag though a producer is inside
 *   -DDONE_AFTER_INDEX     the consumer asks whether it is done after its last look at the index
 *   -DWAKE_SKIPPED         who sets the done flag does not ring
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

inline close() {
  closed = true;
#ifndef WAKE_SKIPPED
  wake(was);
#endif
}

active proctype producer() {
  bool let_in, last, was;
  do
  :: tail < TOTAL ->
    d_step { let_in = open; inside = open };
    if
    :: !let_in -> break
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
    d_step { last = !open; inside = last };
    if
    :: last ->
#ifndef LAST_OUT_IS_SILENT
      close();
#endif
      inside = false
    :: else
    fi
  :: else -> break
  od
}

active proctype stopper() {
  bool alone, was;
#ifdef CLOSED_BEFORE_DOOR
  closed = true;
#endif
  d_step { alone = !inside; open = false };
#ifdef WHO_STOPS_SAYS_IT
  alone = true;
#endif
  if
  :: alone -> close()
  :: else
  fi
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
