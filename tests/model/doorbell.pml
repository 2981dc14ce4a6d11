/* Doorbell: a consumer that sleeps until the tail has reached what it wants, a producer that rings
 * only if it must, and a third thread that asks for something (stop, flush). No deadline, so a lost
 * wake-up is a deadlock. Steps as in doorbell.hpp; the futex compares and falls asleep in one step.
 *
 * Each of these mutants must be refuted:
 *   -DASLEEP_AFTER_CHECK    the consumer looks once more before it says that it sleeps
 *   -DWANTED_AFTER_CHECK    it says what it wants after that look
 *   -DRING_BEFORE_TAIL      the producer rings, then publishes
 *   -DRING_SKIPPED          the producer does not ring
 *   -DWAKE_SKIPPED          the third thread does not ring
 *   -DWAKE_BEFORE_ASKED     it rings, then says what it asks for
 *   -DREADY_WITHOUT_ASKED   the look before sleep is at the tail alone
 *   -DFUTEX_WITHOUT_COMPARE the consumer falls asleep whatever the word says
 */
#ifndef TOTAL
#define TOTAL 3
#endif
#define FUTEX_WAKE sleeping = false

byte tail, wanted, asked;
bool asleep;      /* the word */
bool sleeping;    /* in the kernel's queue */

inline exchange_asleep(before, value) { d_step { before = asleep; asleep = value } }

inline wake(was) {
  exchange_asleep(was, false);
  if
  :: was -> FUTEX_WAKE
  :: else
  fi
}

inline announce(was) {
  was = asleep;      /* the fetch_or of 0 */
  if
  :: was && tail >= wanted -> wake(was)
  :: else
  fi
}

active proctype producer() {
  bool was;
  do
  :: tail < TOTAL ->
#ifdef RING_BEFORE_TAIL
    announce(was);
    tail++
#else
    tail++;
#ifndef RING_SKIPPED
    announce(was)
#endif
#endif
  :: else -> break
  od
}

active proctype stopper() {
  bool was;
  do
  :: asked < 2 ->
#ifdef WAKE_BEFORE_ASKED
    wake(was);
    asked++
#else
    asked++;
#ifndef WAKE_SKIPPED
    wake(was)
#endif
#endif
  :: else -> break
  od
}

/* Ends when it has seen everything and everybody. Wants any tail, also one that is never reached:
 * then only the third thread can wake it. */
active proctype consumer() {
  byte want, seen_asked, seen_tail;
  bool ready, was;
  do
  :: true ->
    seen_asked = asked;
    seen_tail = tail;
    if
    :: seen_asked == 2 && seen_tail == TOTAL -> break
    :: else
    fi;
    select(want : seen_tail + 1 .. TOTAL + 1);
    if
    :: seen_asked == 2 && want > TOTAL -> want = TOTAL
    :: else
    fi;
#ifdef ASLEEP_AFTER_CHECK
    ready = tail >= want || asked != seen_asked;
#endif
#ifndef WANTED_AFTER_CHECK
    wanted = want;
#endif
    exchange_asleep(was, true);
#ifdef READY_WITHOUT_ASKED
    ready = tail >= want;
#else
#ifndef ASLEEP_AFTER_CHECK
    ready = tail >= want;
    ready = ready || asked != seen_asked;
#endif
#endif
#ifdef WANTED_AFTER_CHECK
    wanted = want;
#endif
    if
    :: ready
    :: else ->
#ifdef FUTEX_WITHOUT_COMPARE
      sleeping = true;
      !sleeping
#else
      d_step {
        if
        :: asleep -> sleeping = true
        :: else
        fi
      };
      !sleeping
#endif
    fi;
    exchange_asleep(was, false);
    ready = false; want = 0; was = false
  od
}
