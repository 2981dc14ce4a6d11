/* Telemetry: a reader's copy is of one moment, and ends, whatever the writer does; the writer never
 * waits, and writes into no copy whose reader has gone. telemetry.hpp, telemetry.cpp, two readers.
 *
 * Each of these mutants must be refuted:
 *   -DODD_IGNORED           a reader copies though a step is under way
 *   -DSECOND_LOOK_SKIPPED   it does not look at the number of steps again
 *   -DTAKEN_NOT_AWAITED     it goes on though the writer has taken its request
 */
byte steps, a, b, asked;  /* asked: by which reader; 0: by none */
byte copy_a[3], copy_b[3];
bool is_made[3], gone[3];

active proctype writer() {
  byte who;
  do
  :: steps < 4 ->
    steps++;
    a++;
    b++;
    steps++;
    d_step { who = asked; asked = 0 };
    if
    :: who > 0 -> copy_a[who] = a; copy_b[who] = b; assert(!gone[who]); is_made[who] = true
    :: else
    fi
  :: else -> break
  od
}

active [2] proctype reader() {
  byte before; bool is_asked, is_taken;
  do
  :: true ->
    before = steps;
    if
#ifdef ODD_IGNORED
    :: true ->
#else
    :: before % 2 == 0 ->
#endif
      copy_a[_pid] = a;
      copy_b[_pid] = b;
#ifdef SECOND_LOOK_SKIPPED
      before = steps;
#endif
      if
      :: steps == before -> break
      :: else
      fi
    :: else
    fi;
    d_step { is_asked = (asked == 0); asked = (is_asked -> _pid : asked) };
    d_step { is_taken = is_asked && asked != _pid; asked = (asked == _pid -> 0 : asked) };
#ifndef TAKEN_NOT_AWAITED
    if
    :: is_taken -> is_made[_pid]; break
    :: else
    fi
#endif
  od;
  assert(copy_a[_pid] == copy_b[_pid]);
  gone[_pid] = true
}
