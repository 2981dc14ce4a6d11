/* EventBuffer: one producer, one consumer, the copies of each other's index, the return to the
 * first slot where the ring is empty, and the end of the stream. Every access to memory is a step of its own, in the order of event_buffer.hpp.
 * Sequentially consistent: memory orders are Relacy's.
 *
 * -DCAP= capacity, -DBATCH= largest push, -DTOTAL= events. Each of these mutants must be refuted:
 *   -DINDEX_BEFORE_DATA    tail is stored before the events
 *   -DHEAD_BEFORE_READ     head is stored before the events have been read
 *   -DSTALE_HEAD           the producer refreshes its copy of head and goes on with the old one
 *   -DSTALE_TAIL           the consumer likewise, with its copy of tail
 *   -DCLOSED_BEFORE_TAIL   the done flag is stored before the last index
 *   -DDONE_AFTER_PEEK      the consumer asks whether it is done after its last look at the index
 *   -DBACK_TOO_EARLY       the producer goes back to the first slot while an event waits
 *   -DBASE_AFTER_TAIL      the base is stored after the tail
 *   -DBASE_READ_FIRST      the consumer reads the base before the tail
 *   -DOVERFLOW_LOST        what does not fit is not counted
 */
#ifndef CAP
#define CAP 2
#endif
#ifndef BATCH
#define BATCH 2
#endif
#ifndef TOTAL
#define TOTAL 5
#endif
#define SLOTS 4          /* bit_ceil(3); the ring uses as many as bit_ceil(CAP) */
#define MASK (CAP == 1 -> 0 : (CAP == 2 -> 1 : 3))
#define NOTHING 255

byte slots[SLOTS];
byte tail, head;         /* the shared indices */
byte base;               /* the index at the first slot */
byte overflow;
bool closed;
byte pushed;             /* events offered so far: what a caller knows */

active proctype producer() {
  byte head_copy, n, taken, i, room_before, next_base;
  do
  :: pushed < TOTAL ->
    select(n : 1 .. BATCH);
    if
    :: n > TOTAL - pushed -> n = TOTAL - pushed
    :: else
    fi;
    d_step { pushed = pushed + n; room_before = CAP - (tail - head) }
    taken = head_copy;                        /* the copy that a mutant goes on with */
    if
    :: CAP - (tail - head_copy) < n -> head_copy = head
    :: else
    fi;
#ifndef STALE_HEAD
    taken = head_copy;
#endif
    taken = CAP - (tail - taken);             /* free */
    if
    :: taken > n -> taken = n
    :: else
    fi;
    assert(taken == n || taken >= room_before);   /* nothing is dropped while there is room */
    if
    :: taken < n ->
#ifndef OVERFLOW_LOST
      overflow = overflow + (n - taken)
#endif
    :: else
    fi;
#ifdef CLOSED_BEFORE_TAIL
    if
    :: pushed == TOTAL -> closed = true
    :: else
    fi;
#endif
    n = tail;
    next_base = base;
    if
    :: ((n - base) & MASK) >= 1 ->            /* the ring of the source has a larger `near` */
      if
      :: n != head_copy -> head_copy = head
      :: else
      fi;
      if
#ifdef BACK_TOO_EARLY
      :: n - head_copy <= 1 -> next_base = n
#else
      :: n == head_copy -> next_base = n
#endif
      :: else
      fi
    :: else
    fi;
#ifndef BASE_AFTER_TAIL
    base = next_base;
#endif
#ifdef INDEX_BEFORE_DATA
    tail = tail + taken;
#endif
    i = 0;
    do
    :: i < taken -> slots[(n + i - next_base) & MASK] = n + i; i++
    :: else -> break
    od;
#ifndef INDEX_BEFORE_DATA
    tail = tail + taken;
#endif
#ifdef BASE_AFTER_TAIL
    base = next_base;
#endif
    n = 0; taken = 0; i = 0; room_before = 0; next_base = 0
  :: else -> break
  od;
  closed = true
}

active proctype consumer() {
  byte tail_copy, base_copy, limit, size, i, there;
  bool done;
  do
  :: true ->
#ifndef DONE_AFTER_PEEK
    done = closed;
#endif
    select(limit : 1 .. CAP);
    there = tail - head;                      /* what a peek from now on must see */
    size = tail_copy;
    if
    :: tail_copy - head < limit ->
#ifdef BASE_READ_FIRST
      base_copy = base;
      tail_copy = tail
#else
      tail_copy = tail;
      base_copy = base
#endif
    :: else
    fi;
#ifndef STALE_TAIL
    size = tail_copy;
#endif
    size = size - head;
    if
    :: size > limit -> size = limit
    :: else
    fi;
    assert(size == limit || size >= there);
    assert(size <= CAP);
#ifdef HEAD_BEFORE_READ
    there = head;
    head = head + size;
#else
    there = head;
#endif
    i = 0;
    do
    :: i < size -> assert(slots[(there + i - base_copy) & MASK] == there + i); i++
    :: else -> break
    od;
    do                                        /* they stay valid until consumed */
    :: i > 0 -> i--; assert(slots[(there + i - base_copy) & MASK] == there + i)
    :: else -> break
    od;
#ifndef HEAD_BEFORE_READ
    head = head + size;
#endif
#ifdef DONE_AFTER_PEEK
    done = closed;
#endif
    if
    :: done && size == 0 -> break
    :: else
    fi;
    limit = 0; size = 0; there = 0; done = false
  od;
  assert(head == tail);
  assert(head + overflow == TOTAL)            /* nothing was lost without a count */
}
