/* PushDoor: two producers, one thread that shuts, twice, and begins anew. Every run is ended once,
 * by the one who shuts or by the last one out, when nobody is inside; nothing is pushed after that
 * until the next run. Nobody who shuts waits. Steps as in push_door.hpp and pipeline.cpp.
 *
 * Each of these mutants must be refuted:
 *   -DSHUT_ENDS            who shuts ends the run, though somebody is inside
 *   -DNOBODY_ENDS          the last one out does not end the run
 *   -DOUT_BEFORE_END       the last one out leaves, then ends the run
 *   -DBEGIN_WITHOUT_WAIT   a new run begins while somebody is inside
 *   -DINTRUDER_LEAVES      who finds somebody inside takes his mark away
 *   -DLOOK_THEN_ENTER      entering is two operations
 *   -DLOOK_THEN_LEAVE      leaving is two operations
 */
bool open, inside;   /* the two bits of the word */
byte guests;         /* who really is inside */
bool ended = true;
byte turn;            /* the number of the run */
byte pushed;

inline enter(let_in) {
#ifdef LOOK_THEN_ENTER
  let_in = open && !inside;
  if
  :: let_in -> inside = true
  :: else
  fi;
#else
  d_step {
    let_in = open && !inside;
    if
    :: let_in -> inside = true
    :: else
    fi
  };
#endif
#ifdef INTRUDER_LEAVES
  if
  :: !let_in -> inside = false
  :: else
  fi
#endif
}

inline end_run() {
  assert(!ended && guests == 0);
  copy = pushed;
  assert(copy == pushed);
  ended = true
}

inline leave(last) {
#ifdef LOOK_THEN_LEAVE
  last = !open;
  if
  :: !last -> inside = false
  :: else
  fi;
#else
  d_step {
    last = !open;
    if
    :: !last -> inside = false
    :: else
    fi
  };
#endif
  if
  :: last ->
#ifdef OUT_BEFORE_END
    inside = false;
#endif
#ifndef NOBODY_ENDS
    end_run();
#endif
    assert(turn == mine);
    inside = false
  :: else
  fi
}

active [2] proctype producer() {
  bool let_in, last;
  byte visits, copy, mine;
  do
  :: visits < 2 ->
    visits++;
    enter(let_in);
    if
    :: let_in ->
      guests++;
      mine = turn;
      assert(guests == 1 && !ended);
      copy = pushed;            /* a push that two at once would tear */
      assert(guests == 1 && !ended);
      pushed = copy + 1;
      assert(guests == 1 && !ended && turn == mine);
      guests--;
      leave(last)
    :: else
    fi;
    let_in = false; last = false; copy = 0; mine = 0
  :: else -> break
  od
}

active proctype owner() {
  bool alone;
  byte rounds, copy;
  do
  :: rounds < 4 ->
    if
    :: rounds % 2 == 0 ->
#ifndef BEGIN_WITHOUT_WAIT
      !inside;
#endif
      assert(ended);
      turn++;
      ended = false;
      open = true
    :: else
    fi;
    d_step { alone = open && !inside; open = false };
#ifdef SHUT_ENDS
    alone = rounds % 2 == 0;
#endif
    if
    :: alone -> end_run()
    :: else
    fi;
    alone = false; copy = 0;
    rounds++
  :: else -> break
  od;
  !inside;
  assert(ended)
}
