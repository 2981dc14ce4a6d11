/* PushDoor: two producers, one thread that closes and opens again. When close() has returned nobody
 * is inside, and nothing is pushed until the door is opened. Steps as in push_door.hpp.
 *
 * Each of these mutants must be refuted:
 *   -DCLOSE_WITHOUT_WAIT   close() does not wait for the one inside
 *   -DINTRUDER_LEAVES      who finds somebody inside takes his mark away
 *   -DLOOK_THEN_ENTER      entering is two operations
 *   -DNOBODY_LEAVES        a producer at a shut door leaves his mark behind
 */
bool open, inside;   /* the two bits of the word */
byte guests;         /* who really is inside */
bool shut = true;    /* close() has returned */
byte pushed;

inline leave() { inside = false }

inline enter(let_in) {
#ifdef LOOK_THEN_ENTER
  was_open = open; was_inside = inside;
  inside = true;
#else
  d_step { was_open = open; was_inside = inside; inside = true }
#endif
  let_in = false;
  if
  :: was_open && !was_inside -> let_in = true
#ifdef INTRUDER_LEAVES
  :: else -> leave()
#else
#ifdef NOBODY_LEAVES
  :: else
#else
  :: !was_open && !was_inside -> leave()
  :: was_inside
#endif
#endif
  fi
}

active [2] proctype producer() {
  bool was_open, was_inside, let_in;
  byte visits, copy;
  do
  :: visits < 2 ->
    visits++;
    enter(let_in);
    if
    :: let_in ->
      guests++;
      assert(guests == 1 && !shut);
      copy = pushed;            /* a push that two at once would tear */
      assert(!shut);
      pushed = copy + 1;
      assert(guests == 1 && !shut);
      guests--;
      leave()
    :: else
    fi;
    let_in = false; was_open = false; was_inside = false; copy = 0
  :: else -> break
  od
}

active proctype owner() {
  byte rounds, seen;
  do
  :: rounds < 2 ->
    rounds++;
    shut = false;
    open = true;
    open = false;
#ifndef CLOSE_WITHOUT_WAIT
    !inside;
#endif
    shut = true;
    assert(guests == 0);
    seen = pushed;
    assert(seen == pushed)
  :: else -> break
  od
}
