"""The reference study's figures per profile. Only numbers."""

from __future__ import annotations

__all__ = ["FURTHER_SCORES", "PER_PROFILE"]

#: By cost model and quantity, a table of contenders by profiles; mean of three seeds.
PER_PROFILE = {
    ("fast", "score"): """
        | quiet low uav flicker steps bursts high ramp steps60
        OB(L)/input | 1 1 1 1 1 1 1 1 .839
        FixedSize 1000 | .005 .2 .995 .982 .981 .86 1 1 .056
        FixedSize 5000 | .001 .038 .702 .916 .957 .892 1 .994 .065
        FixedTime 1 ms | 1 1 1 1 1 1 1 1 .064
        FixedTime 20 ms | .098 .097 .062 .007 .005 .016 0 .002 .004
        Asap2020 best | .793 .998 1 .999 1 .995 1 1 .829
        Asap2022 best | .178 .998 1 .992 1 .927 1 .999 .07
        Spark PID | 1 1 1 .97 1 .992 1 1 .907
        Clipper AIMD | 1 1 1 1 1 1 1 1 .071
        Greedy | 1 1 1 1 1 1 1 1 .072
        greedy+PIE | 1 1 1 1 1 1 1 1 .352
        greedy+clear | 1 1 1 1 1 1 1 1 .927
        greedy+rate-gamma | 1 1 1 1 1 1 1 1 .538
        jAER timer | 1 1 1 1 1 1 1 1 .985
        opaque DeadBeat | 1 1 1 1 1 1 1 1 .979
        DeadBeat L/2 | 1 1 1 1 1 1 1 1 .984
        DeadBeat | 1 1 1 1 1 1 1 1 .975
        DeadBeat oh.25 | 1 1 1 1 1 1 1 1 .976
        """,
    ("fast", "p99_ms"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | 505 10.7 1.62 4.73 2.64 3.68 .166 .36 41.3
        FixedSize 5000 | 2506 50.9 7.91 5.93 13.2 9.31 .734 1.58 25.3
        FixedTime 1 ms | 1.01 1.01 1.05 1.14 1.14 1.74 1.24 1.39 21.8
        FixedTime 20 ms | 19.8 19.9 20.6 21.2 22.3 26.5 23.9 26.7 41.4
        Asap2020 best | 454 .124 .0583 .248 .0571 .496 .0632 .136 1.93
        Asap2022 best | 454 .375 .182 1.22 1.06 4.31 .114 .729 30
        Spark PID | 1.01 1.01 1.05 1.14 1.14 1.74 1.24 1.39 2.13
        Clipper AIMD | .0363 .0422 .0439 .049 .049 .336 .0565 .0767 22
        Greedy | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 21.5
        greedy+PIE | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 5.5
        greedy+clear | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 2.16
        greedy+rate-gamma | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 5.43
        jAER timer | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 1.98
        opaque DeadBeat | .0363 .0422 .0439 .049 .049 .271 .0565 .0767 1.93
        DeadBeat L/2 | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 1.98
        DeadBeat | .0363 .0422 .0439 .049 .049 .268 .0565 .0767 1.58
        DeadBeat oh.25 | .0957 .101 .105 .112 .113 .272 .121 .132 1.59
        """,
    ("fast", "kept"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | .91 1 1 1 1 1 1 1 .49
        FixedSize 5000 | .51 1 1 1 1 1 1 1 .74
        FixedTime 1 ms | 1 1 1 1 1 1 1 1 .86
        FixedTime 20 ms | 1 1 .99 1 .99 1 1 .99 .47
        Asap2020 best | 1 1 1 1 1 1 1 1 .7
        Asap2022 best | 1 1 1 1 1 1 1 1 .63
        Spark PID | 1 1 1 .97 1 .99 1 1 .81
        Clipper AIMD | 1 1 1 1 1 1 1 1 .85
        Greedy | 1 1 1 1 1 1 1 1 .86
        greedy+PIE | 1 1 1 1 1 1 1 1 .83
        greedy+clear | 1 1 1 1 1 1 1 1 .8
        greedy+rate-gamma | 1 1 1 1 1 1 1 1 .83
        jAER timer | 1 1 1 1 1 1 1 1 .83
        opaque DeadBeat | 1 1 1 1 1 1 1 1 .82
        DeadBeat L/2 | 1 1 1 1 1 1 1 1 .83
        DeadBeat | 1 1 1 1 1 1 1 1 .82
        DeadBeat oh.25 | 1 1 1 1 1 1 1 1 .82
        """,
    ("slow", "score"): """
        | quiet low uav flicker steps bursts high ramp steps60
        OB(L)/input | 1 1 1 1 .584 .321 .332 .305 .101
        FixedSize 1000 | .019 .943 .911 .008 .044 .005 .002 .071 .01
        FixedSize 5000 | .002 .168 .992 .962 .048 .008 .002 .098 .095
        FixedTime 1 ms | 1 1 1 .208 .06 .003 .002 .096 .093
        FixedTime 20 ms | .494 .462 .054 0 .02 0 0 .004 0
        Asap2020 best | .812 1 .988 .437 .791 .288 .808 .822 .781
        Asap2022 best | .698 1 .986 .971 .171 .37 .029 .183 .095
        Spark PID | .999 .999 .998 .565 .895 .746 .88 .905 .925
        Clipper AIMD | 1 1 1 .986 .066 .006 .002 .1 .096
        Greedy | 1 1 1 .985 .082 .015 .001 .103 .096
        greedy+PIE | 1 1 .999 .944 .409 .323 .002 .221 .389
        greedy+clear | 1 1 1 .968 .823 .526 .523 .57 .476
        greedy+rate-gamma | 1 1 1 .914 .78 .551 .839 .868 .466
        jAER timer | 1 1 1 .988 .983 .886 .99 .989 .988
        opaque DeadBeat | 1 1 1 .982 .976 .867 .984 .984 .984
        DeadBeat L/2 | 1 1 1 .987 .983 .883 .99 .989 .988
        DeadBeat | 1 1 1 .978 .97 .838 .979 .98 .981
        DeadBeat oh.25 | 1 1 1 .976 .968 .812 .979 .979 .982
        """,
    ("slow", "p99_ms"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | 505 11.1 29.5 419 419 415 419 419 419
        FixedSize 5000 | 2506 52.4 9.37 12.2 337 334 337 337 337
        FixedTime 1 ms | 1.09 1.13 2.22 48.4 337 341 346 349 351
        FixedTime 20 ms | 20 20.6 35.3 40.9 313 266 325 331 340
        Asap2020 best | 454 .36 2.61 7.29 4.26 48.3 6.07 3.96 17.5
        Asap2022 best | 454 .477 10.8 11.5 165 97.7 106 336 334
        Spark PID | 5.06 5.21 9.03 10.1 10.7 86.8 33.8 10.8 10.6
        Clipper AIMD | .198 .214 1.82 10.2 324 310 326 327 327
        Greedy | .198 .214 1.81 10.5 319 305 334 330 329
        greedy+PIE | .198 .214 1.76 7.97 15.1 73.8 25.5 46.5 188
        greedy+clear | .198 .214 1.81 8.68 13.5 53.9 20.4 31.6 84.4
        greedy+rate-gamma | .198 .214 1.81 6.84 13.1 22.8 17.5 12 30.5
        jAER timer | .198 .214 1.81 8.13 9.95 9.95 9.95 9.95 9.95
        opaque DeadBeat | .198 .214 1.81 7.97 9.72 9.59 9.75 9.75 9.59
        DeadBeat L/2 | .198 .214 1.81 8.05 9.95 9.88 9.95 9.95 9.95
        DeadBeat | .198 .214 1.81 7.94 6.75 8.15 6.71 6.64 6.86
        DeadBeat oh.25 | .498 .514 1.85 7.94 6.77 8.04 6.73 6.61 6.79
        """,
    ("slow", "kept"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | .91 1 1 .9 .78 .78 .27 .26 .09
        FixedSize 5000 | .51 1 1 1 .87 .95 .33 .31 .11
        FixedTime 1 ms | 1 1 1 1 .88 .92 .33 .3 .1
        FixedTime 20 ms | 1 1 .99 1 .86 .99 .35 .32 .11
        Asap2020 best | 1 1 .99 .44 .46 .09 .27 .25 .08
        Asap2022 best | 1 1 1 1 .61 .58 .17 .3 .11
        Spark PID | 1 1 1 .57 .56 .26 .32 .3 .1
        Clipper AIMD | 1 1 1 1 .83 .94 .33 .3 .1
        Greedy | 1 1 1 1 .73 .97 .34 .31 .11
        greedy+PIE | 1 1 1 .94 .58 .63 .33 .3 .1
        greedy+clear | 1 1 1 .97 .56 .33 .32 .3 .1
        greedy+rate-gamma | 1 1 1 .91 .57 .35 .33 .3 .1
        jAER timer | 1 1 1 .99 .57 .28 .33 .3 .1
        opaque DeadBeat | 1 1 1 .98 .57 .28 .33 .3 .1
        DeadBeat L/2 | 1 1 1 .99 .57 .28 .33 .3 .1
        DeadBeat | 1 1 1 .98 .57 .27 .32 .3 .1
        DeadBeat oh.25 | 1 1 1 .98 .56 .26 .32 .3 .1
        """,
    ("slow_ht", "score"): """
        | low uav flicker steps bursts high ramp
        OB(L)/input | .997 .996 .995 .713 .366 .413 .37
        FixedSize 1000 | .937 .768 .007 .032 .004 .001 .053
        FixedSize 5000 | .166 .96 .32 .035 .005 .002 .072
        FixedTime 1 ms | .999 .972 .023 .043 .004 .001 .079
        FixedTime 20 ms | .458 .095 .001 .014 .01 0 .005
        Asap2020 best | .992 .928 .427 .521 .165 .52 .552
        Asap2022 best | .998 .705 .114 .096 .142 .065 .045
        Spark PID | .997 .89 .44 .247 .521 .149 .23
        Clipper AIMD | 1 .974 .546 .056 .003 .001 .071
        Greedy | 1 .98 .535 .067 .065 .001 .083
        greedy+PIE | .991 .978 .819 .456 .304 .083 .228
        greedy+clear | .99 .981 .807 .648 .442 .482 .521
        greedy+rate-gamma | 1 .976 .795 .658 .501 .488 .655
        jAER timer | 1 .991 .938 .887 .821 .93 .915
        opaque DeadBeat | .997 .987 .842 .748 .705 .729 .756
        DeadBeat L/2 | .997 .993 .941 .917 .862 .989 .969
        DeadBeat | .997 .993 .937 .921 .809 .988 .966
        DeadBeat oh.25 | .997 .991 .932 .902 .814 .989 .955
        """,
    ("slow_ht", "p99_ms"): """
        | low uav flicker steps bursts high ramp
        FixedSize 1000 | 12.7 54.4 458 448 444 460 454
        FixedSize 5000 | 52.8 16.2 60.5 371 359 381 380
        FixedTime 1 ms | 5.01 14.8 196 353 382 385 391
        FixedTime 20 ms | 22 62 111 397 356 452 428
        Asap2020 best | 10.7 16.1 12.3 41.7 171 24.4 70.1
        Asap2022 best | 6.21 16.2 95.1 154 110 187 406
        Spark PID | 7.27 21.1 35.4 47.4 105 80.4 99.2
        Clipper AIMD | 4.28 12.9 45.1 361 362 380 369
        Greedy | 4.35 14.1 159 487 527 645 540
        greedy+PIE | 1.61 6.57 15.4 27.7 124 49.8 66.9
        greedy+clear | 1.04 4.86 14.6 19.5 74.5 34.5 48
        greedy+rate-gamma | 4.35 13.7 33.8 52 47.9 151 31.7
        jAER timer | 4.35 9.25 10.9 13.8 15 14.5 14.6
        opaque DeadBeat | 1.64 5.25 9.82 12.8 13.5 14.2 13.4
        DeadBeat L/2 | 1.62 5.62 9.09 9.95 9.91 9.95 9.98
        DeadBeat | 1.62 5.67 8.8 9.59 9.56 9.95 9.95
        DeadBeat oh.25 | 1.76 6.52 8.89 9.66 9.62 9.95 9.95
        """,
    ("slow_ht", "kept"): """
        | low uav flicker steps bursts high ramp
        FixedSize 1000 | 1 1 .88 .77 .76 .27 .25
        FixedSize 5000 | 1 1 1 .86 .93 .33 .3
        FixedTime 1 ms | 1 1 1 .87 .89 .32 .3
        FixedTime 20 ms | 1 .99 1 .87 .95 .34 .31
        Asap2020 best | 1 .96 .43 .4 .08 .23 .24
        Asap2022 best | 1 .74 .9 .46 .51 .25 .24
        Spark PID | 1 .97 .62 .55 .31 .31 .29
        Clipper AIMD | 1 1 1 .81 .9 .31 .29
        Greedy | 1 1 1 .72 .9 .32 .32
        greedy+PIE | .99 .98 .86 .56 .62 .33 .3
        greedy+clear | .99 .98 .84 .54 .33 .31 .3
        greedy+rate-gamma | 1 .99 .87 .54 .37 .31 .28
        jAER timer | 1 .99 .95 .66 .31 .41 .36
        opaque DeadBeat | .99 .98 .85 .55 .27 .32 .29
        DeadBeat L/2 | .99 .99 .94 .66 .32 .41 .36
        DeadBeat | .99 .99 .93 .66 .3 .41 .36
        DeadBeat oh.25 | .99 .99 .93 .65 .3 .41 .36
        """,
    ("slow_tv", "score"): """
        | low uav flicker steps bursts high ramp
        OB(L)/input | 1 .944 .858 .732 .319 .326 .289
        Asap2020 best | 1 .765 .411 .599 .265 .435 .464
        Asap2022 best | 1 .675 .617 .193 .244 .229 .118
        Greedy | 1 .572 .236 .052 .055 .002 .139
        greedy+PIE | 1 .962 .851 .754 .308 .154 .329
        greedy+rate-gamma | 1 .95 .862 .739 .547 .257 .42
        jAER timer | 1 .989 .986 .98 .885 .992 .991
        opaque DeadBeat | 1 .986 .965 .961 .854 .974 .975
        DeadBeat L/2 | 1 .988 .985 .979 .888 .992 .991
        DeadBeat | 1 .982 .974 .971 .834 .989 .983
        DeadBeat oh.25 | 1 .976 .97 .974 .824 .989 .983
        """,
    ("slow_tv", "p99_ms"): """
        | low uav flicker steps bursts high ramp
        Asap2020 best | .386 16.3 39.8 39.6 81.3 14.6 22.9
        Asap2022 best | .48 13.9 37.9 196 187 119 570
        Greedy | .228 307 520 421 594 619 579
        greedy+PIE | .228 11.2 20.5 18 134 52.8 87.8
        greedy+rate-gamma | .228 14.2 27.9 47.8 31.8 356 286
        jAER timer | .228 9.82 9.85 9.95 9.95 9.95 9.95
        opaque DeadBeat | .228 8.94 9.19 9.72 9.69 9.82 9.75
        DeadBeat L/2 | .228 9.72 9.82 9.95 9.88 9.95 9.95
        DeadBeat | .228 6.32 9.59 9.4 8.86 9.88 9.69
        DeadBeat oh.25 | .539 6.24 9.53 9.78 9.46 9.88 9.75
        """,
    ("slow_tv", "kept"): """
        | low uav flicker steps bursts high ramp
        Asap2020 best | 1 .76 .43 .46 .09 .15 .14
        Asap2022 best | 1 .68 .61 .46 .57 .21 .21
        Greedy | 1 .99 .92 .91 .84 .33 .29
        greedy+PIE | 1 .93 .82 .71 .58 .32 .29
        greedy+rate-gamma | 1 .93 .81 .72 .34 .32 .28
        jAER timer | 1 .93 .85 .72 .28 .32 .29
        opaque DeadBeat | 1 .93 .83 .71 .27 .32 .28
        DeadBeat L/2 | 1 .93 .84 .72 .28 .32 .29
        DeadBeat | 1 .93 .83 .71 .27 .32 .28
        DeadBeat oh.25 | 1 .92 .83 .71 .26 .32 .28
        """,
    ("slow", "packages_per_s"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | 2 100 1544 2696 2436 2623 2691 2546 2691
        FixedTime 1 ms | 927 999 999 999 998 981 829 929 892
        Asap2020 best | 1362 7424 4245 923 4619 4356 965 1724 1592
        Greedy | 1930 9605 5309 937 3211 28 8 834 117
        DeadBeat | 1930 9605 5309 1143 4630 7141 299 1075 636
        DeadBeat oh.25 | 1563 2493 2380 637 1390 2180 298 610 626
        DeadBeat 1kHz | 927 999 992 443 649 892 298 407 507
        """,
    ("slow", "cpu"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | 0 .04 .62 1 .98 1 1 1 1
        FixedTime 1 ms | .09 .13 .56 1 .93 1 1 1 1
        Asap2020 best | .14 .77 .88 .49 .9 .53 .9 .92 .92
        Greedy | .19 .99 .99 1 1 1 1 1 1
        DeadBeat | .19 .99 .99 1 1 .99 1 1 1
        DeadBeat oh.25 | .16 .28 .7 .95 .67 .49 1 .95 1
        DeadBeat 1kHz | .09 .13 .56 .91 .6 .36 1 .93 .99
        """,
    ("slow", "p50_ms"): """
        | quiet low uav flicker steps bursts high ramp steps60
        FixedSize 1000 | 258 5.33 .846 415 260 371 419 419 419
        FixedTime 1 ms | .563 .632 1.19 32.1 193 287 342 344 339
        Asap2020 best | .347 .183 .491 1.13 1.4 .223 1.95 1.48 1.12
        Greedy | .102 .155 .375 4.59 209 154 287 285 291
        DeadBeat | .102 .155 .375 4.06 4.84 2.72 5.03 4.83 3.81
        DeadBeat oh.25 | .19 .312 .559 4.19 4.83 1.96 5.05 4.79 3.82
        DeadBeat 1kHz | .559 .632 1.19 4.55 4.83 3.51 5.04 4.83 3.88
        """,
}

#: By cost model, a table of profiles by contenders: scores of seed 1.
FURTHER_SCORES = {
    "slow": """
        | DeadBeat_L/2 DeadBeat jAER_timer Deadline
        flicker | .991 .985 .993 .998
        steps | .982 .969 .981 .974
        bursts | .884 .836 .891 .976
        high | .99 .977 .991 .99
        ramp | .99 .979 .99 .988
        steps60 | .988 .981 .988 .988
        sawtooth | .97 .957 .971 .974
        spikes | .873 .818 .871 .975
        walk | .975 .959 .975 .973
        breath | .983 .969 .984 .977
        twostep | .976 .968 .977 .977
        telegraph | .931 .893 .93 .97
        ou4ms | .944 .919 .942 .96
        train | .971 .943 .971 .98
        """,
    "fast": """
        | DeadBeat_L/2 DeadBeat jAER_timer Deadline
        flicker | 1 1 1 1
        steps | 1 1 1 1
        bursts | 1 1 1 1
        high | 1 1 1 1
        ramp | 1 1 1 1
        steps60 | .985 .976 .986 .982
        sawtooth | .987 .977 .987 .979
        spikes | .95 .926 .95 .988
        walk | .984 .975 .985 .982
        breath | .988 .98 .989 .987
        twostep | .99 .979 .992 .989
        telegraph | .965 .945 .966 .979
        ou4ms | .955 .934 .956 .968
        train | .852 .79 .85 .965
        """,
    "slow_tv": """
        | DeadBeat_L/2 DeadBeat jAER_timer Deadline
        flicker | .989 .976 .99 .991
        steps | .978 .968 .98 .971
        bursts | .89 .83 .885 .976
        high | .994 .988 .994 .994
        ramp | .986 .98 .986 .987
        steps60 | .995 .99 .995 .993
        sawtooth | .966 .953 .965 .967
        spikes | .861 .798 .868 .952
        walk | .974 .96 .974 .97
        breath | .983 .972 .983 .975
        twostep | .958 .948 .958 .964
        telegraph | .935 .907 .938 .959
        ou4ms | .952 .942 .951 .966
        train | .981 .968 .981 .984
        """,
    "slow_ht": """
        | DeadBeat_L/2 DeadBeat jAER_timer Deadline
        flicker | .942 .938 .932 .956
        steps | .889 .899 .854 .89
        bursts | .851 .83 .825 .928
        high | 1.004 1.002 .932 1.003
        ramp | .973 .967 .918 .967
        steps60 | .987 .993 .931 .98
        sawtooth | .902 .886 .91 .923
        spikes | .834 .781 .796 .908
        walk | .954 .891 .952 .939
        breath | .945 .941 .921 .92
        twostep | .932 .911 .84 .927
        telegraph | .898 .871 .801 .874
        ou4ms | .85 .829 .785 .88
        train | .865 .857 .847 .873
        """,
}
