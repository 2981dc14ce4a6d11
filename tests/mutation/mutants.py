"""The mutants: each a line of the core, the live path or a decoder, broken as by a tired hand."""

from __future__ import annotations

from dataclasses import dataclass

INCLUDE = "cpp/include/asap/"
SOURCE = "cpp/src/"


@dataclass(frozen=True)
class Mutant:
    """`old`, which stands once in the file, becomes `new`; one of the tests has to fail."""

    words: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    # Race detection: it knows the order of memory, which this machine may not show.
    threads: bool = False


def in_file(
    file: str, *tests: str, threads: bool = False, **changes: tuple[str, str]
) -> list[Mutant]:
    return [
        Mutant(words.replace("_", " "), file, old, new, tests, threads)
        for words, (old, new) in changes.items()
    ]


MUTANTS: list[Mutant] = [
    *in_file(
        SOURCE + "buffer/event_buffer.hpp",
        "race",
        threads=True,
        tail_published_relaxed=(
            "tail_.store(tail + taken, std::memory_order_release)",
            "tail_.store(tail + taken, std::memory_order_relaxed)",
        ),
        head_published_relaxed=(
            "+ count, std::memory_order_release)",
            "+ count, std::memory_order_relaxed)",
        ),
    ),
    *in_file(
        SOURCE + "buffer/event_buffer.hpp",
        "buffer",
        consume_off_by_one=(
            "(std::memory_order_relaxed) + count,",
            "(std::memory_order_relaxed) + count + 1,",
        ),
        overflow_not_counted=(
            "overflow_.store(lost + (events.size() - taken)",
            "overflow_.store(lost",
        ),
        copy_of_head_never_refreshed=(
            "if (capacity_ - (tail - head_copy_) < events.size()) {",
            "if (capacity_ - (tail - head_copy_) > events.size()) {",
        ),
    ),
    *in_file(
        SOURCE + "buffer/arrival_times.hpp",
        "buffer",
        full_table_overwrites_its_oldest_step=("used == steps_ || ", ""),
        event_of_the_step_before=(
            "std::memory_order_relaxed) > index;",
            "std::memory_order_relaxed) >= index;",
        ),
    ),
    *in_file(
        SOURCE + "runner/push_door.hpp",
        "runner",
        last_one_out_does_nothing=("std::forward<LastOut>(last_out)();", ""),
    ),
    *in_file(
        SOURCE + "runner/stall_watch.hpp",
        "runner",
        sleep_counts_as_stall=("return !sleeps_ && now_ns", "return now_ns"),
    ),
    *in_file(
        SOURCE + "runner/sensor_delay.hpp",
        "runner",
        least_delay_forgotten_with_its_window=("std::min(min_ns_, before_ns_)", "min_ns_"),
    ),
    *in_file(
        SOURCE + "runner/intake.cpp",
        "runner",
        "live",
        full_ring_without_wake=("  announce();\n", ""),
        thinned_not_counted=("    discarded_ += block.size() - kept;\n", ""),
        thinning_knows_not_how_much_comes=(
            "buffer_.filled(max - events.size()) > max - events.size()",
            "buffer_.filled(max) > max",
        ),
        thinning_lets_in_more_than_fits=(
            "if (events <= room) return chance;",
            "return chance;",
        ),
        thinning_by_the_room_not_its_square=("left * left * thinned", "left * thinned"),
        producer_not_told_to_leave=("  left_.store(true, std::memory_order_release);\n", ""),
    ),
    *in_file(
        SOURCE + "runner/pipeline.cpp",
        "live",
        "runner",
        arrival_clamp_removed=(
            "std::clamp(arrival.value_or(now), RunClock::Steady::time_point{}, now)",
            "arrival.value_or(now)",
        ),
        forgotten_wake=("      live.intake.announce();\n", ""),
        arrivals_go_back=("std::max(arrival_ns, clock.at(came))", "clock.at(came)"),
        clock_reset_flushes_nothing=(
            "  sensor_delay.forget();\n  loop.flush();",
            "  sensor_delay.forget();",
        ),
        bound_not_applied=("  impl_->live->loop.set_latency_bound(bound_ns);\n", ""),
        end_without_wake=(
            "  run.buffer().close();\n  doorbell.wake();",
            "  run.buffer().close();",
        ),
    ),
    *in_file(
        SOURCE + "runner/run.cpp",
        "live",
        "runner",
        overflow_of_the_consumer_lost=(
            "ledger.overflow += overflow;",
            "ledger.overflow = overflow;",
        ),
        thinned_missing_in_the_ledger=("  ledger.discarded += outside.thinned;\n", ""),
        not_in_the_ring_missing_in_the_ledger=(
            "tail - booked) + outside.waiting;",
            "tail - booked);",
        ),
        books_of_the_run_before=("  telemetry_.reset(bound_ns);\n", ""),
        stamps_of_the_run_before=("  validator_ = Validator(config.validator);\n", ""),
    ),
    *in_file(
        SOURCE + "telemetry/telemetry.cpp",
        "runner",
        copy_of_two_moments=(
            "return steps_.load(std::memory_order_relaxed) == before;",
            "return true;",
        ),
    ),
    *in_file(
        SOURCE + "runner/pipeline.cpp",
        "runner",
        "live",
        forgotten_leave=("  live->intake.leave();\n", ""),
        swallowed_exception=("    throw;\n  }\n  finish();", "  }\n  finish();"),
        swallowed_exception_of_the_worker=("        error = std::current_exception();\n", ""),
        stop_always_drains=("  if (!drain) live->loop.abandon();\n", ""),
        later_runs_have_the_old_bound=("  impl_->latency_bound_ns = bound_ns;\n", ""),
    ),
    *in_file(
        SOURCE + "runner/consumer_loop.cpp",
        "live",
        "runner",
        lost_flush=("  packager_.flush(asked.flush);\n", ""),
        flush_without_wake=(
            "  }\n  doorbell_.wake();",
            "  }",
        ),
    ),
    *in_file(
        SOURCE + "packager/packager.cpp",
        "simulation",
        "packager",
        "runner",
        lost_events_shift_the_random_numbers=("  thinner_.skip(count);\n", ""),
        due_after_the_bound_instead_of_at_it=("now_ns >= flush_ns ||", "now_ns > flush_ns ||"),
        size_of_a_whole_package_by_chance=(
            ".gamma = left / static_cast<double>(last), .exactly = true}",
            ".gamma = left / static_cast<double>(last)}",
        ),
        full_ring_is_not_due=("waiting.size() == buffer_.capacity() || head <", "head <"),
        consumes_what_was_offered=("  consume(package.raw);", "  consume(package.offered);"),
    ),
    *in_file(
        SOURCE + "packager/packager.cpp",
        "race",
        threads=True,
        slots_free_before_they_are_read=(
            "  observe(package, end_ns);\n  consume(package.raw);",
            "  consume(package.raw);\n  observe(package, end_ns);",
        ),
    ),
    *in_file(
        SOURCE + "packager/books.hpp",
        "simulation",
        "runner",
        drop_oldest_not_counted=("telemetry_.overflow += left.count;", ""),
        stale_not_counted=("telemetry_.stale += left.count;", ""),
        filtered_counted_twice=(
            "package.raw - filtered - package.events.size();",
            "package.raw - package.events.size();",
        ),
        overflow_reported_again=("  overflow_reported_ += package.overflow_before;\n", ""),
    ),
    *in_file(
        SOURCE + "packager/anytime_plan.cpp",
        "packager",
        strata_by_count_alone=("std::max(by_count, by_time)", "by_count"),
        strata_as_if_the_guess_were_true=(
            "std::max(decision.event_ns, decision.max_event_ns)",
            "decision.event_ns",
        ),
        fixed_cost_of_one_part_forgotten=(
            "if (strata_ == 1) left_ns -= ",
            "if (false) left_ns -= ",
        ),
        first_part_without_its_fixed_cost=("now_ns - start_ns_}", "now_ns - stratum_start_ns_}"),
    ),
    *in_file(
        SOURCE + "schemes/cost_model.cpp",
        "schemes",
        first_part_not_learned=("if (has_parts) learn(", "if (false) learn("),
        low_cost_of_a_new_size_clipped=("if (bucket(n).is_new()) cost_ns", "if (false) cost_ns"),
        single_event_refutes_no_fixed_cost=("if (n == 1.0 && ", "if (false && "),
        fixed_cost_beyond_the_cheapest_package=(" && fall_ns < min_cost_ns()", ""),
        guess_trusted_from_the_first_package_on=(
            "return on_level() <= kPriorLasts ?",
            "return count_ < 0U ?",
        ),
        rise_of_the_cost_refutes_nothing=(" && cost_ns <= dearer_ns", ""),
        fixed_cost_charged_to_the_events=("if (small.weight > 0 && spare_ns > 0)", "if (false)"),
        slope_without_its_error=("small.cost_ns + error_ns)", "small.cost_ns)"),
        outage_of_the_largest_package_believed=("cost_ns >= max_event_ns_ * size && ", ""),
    ),
    *in_file(
        SOURCE + "schemes/deadline.cpp",
        "schemes",
        whole_package_of_any_size=(
            "    decision = safe_slice(decision, safe);\n",
            "",
        ),
        more_stays_than_can_be_finished=(
            "work_.age_done_within(left_ns - 2.0 * fixed_ns_)",
            "latency_ns_",
        ),
        gap_without_a_price=("throughput - gap_price_ * gap * gap", "throughput"),
        rush_taken_for_its_end=("(is_rush_ ? if_they_go_on(plan) : 0.0)", "0.0"),
        rest_that_is_too_old_counted=(
            "oldest_ns = std::min(oldest_ns, latency_ns_ - now_ns - length_ns);",
            "",
        ),
    ),
    *in_file(
        SOURCE + "filter/validator.cpp",
        "filter",
        stamp_back_by_the_tolerance_is_bad=(
            "back > reorder_tolerance_us_",
            "back >= reorder_tolerance_us_",
        ),
        epoch_that_is_told_overlaps=("last_us_ + 1 - first_us", "last_us_ - first_us"),
        second_back_is_no_epoch=("back >= kNewEpoch_us", "back > kNewEpoch_us"),
        row_below_the_sensor_passes=("(kLane - max_y) << 16", "(kLane - max_y - 1) << 16"),
        short_step_back_passes=("steps >= kSteps_us ||", "steps > ~kSteps_us ||"),
    ),
    *in_file(
        SOURCE + "schemes/asap2020.cpp",
        "schemes",
        gamma_grows_in_overload=(
            "gamma_ * config_.rate_bound / rate)",
            "gamma_ * rate / config_.rate_bound)",
        ),
    ),
    *in_file(
        INCLUDE + "telemetry/latency_histogram.hpp",
        "telemetry",
        at_the_bound_is_late=(
            "latency_ns <= bound_ns_ ? count : 0U",
            "latency_ns < bound_ns_ ? count : 0U",
        ),
    ),
    *in_file(
        SOURCE + "telemetry/gap_meter.hpp",
        "telemetry",
        gap_without_a_loss=("if (is_lost_) extend(", "extend("),
        gap_in_the_last_stride=("    look(event, last);\n", ""),
        gap_within_a_package=("extend(longest_us);\n", ";\n"),
    ),
    *in_file(
        SOURCE + "filter/gamma_filter.cpp",
        "filter",
        gamma_keeps_what_it_should_discard=(
            "kept += random(first + i) < bar",
            "kept += random(first + i) >= bar",
        ),
    ),
    *in_file(
        SOURCE + "algorithms/plane_flow.cpp",
        "algorithms",
        every_event_of_a_burst_has_a_flow=(
            "&& burst_goes_on(now, own)",
            "&& (burst_goes_on(now, own), false)",
        ),
        a_burst_begins_anew_after_its_first_event=(
            "return std::exchange(own[2 * plane_], now) >= now - burst_us_;",
            "return own[2 * plane_] >= now - burst_us_ || (own[2 * plane_] = now, false);",
        ),
        a_burst_is_as_long_as_the_window=("kBurstsPerWindow = 4", "kBurstsPerWindow = 1"),
    ),
    *in_file(
        SOURCE + "algorithms/trimmed_plane_fit.cpp",
        "algorithms",
        outliers_dropped_once=("kTrims = 2", "kTrims = 1"),
        every_pixel_weighs_alike=("kHalf_px2 / (kHalf_px2 + x * x + y * y)", "1"),
        an_outlier_stays_in_the_sums=("      add(point, -1);\n", ""),
        scatter_forgets_the_degrees_of_freedom=("(n - 3) * kScatter_px", "n * kScatter_px"),
        pixels_on_a_line_have_a_plane=("< kOnALine) return false;", "< -1) return false;"),
    ),
    *in_file(
        SOURCE + "algorithms/fast/objects.cpp",
        "algorithms",
        lost_object_stays_where_it_was=("way.velocity.x * unseen_s", "0 * unseen_s"),
        any_lost_object_reappears=("    least = distance;\n", ""),
        lost_object_reappears_twice=("    objects_[object].sum.parts = 1;", "    "),
        way_of_a_starved_object_noted=(" || tracks.state(sum.lead).starved_s > 0", ""),
        young_object_adopts=("now_us_ - object.born_us > kOld_us", "true"),
        what_was_there_before_is_adopted=("now_us_ - child.born_us >= kYoung_us", "false"),
        times_apart_add_up=("first == main ? 0", "first == main ? parts_[slot].apart_s"),
        the_lightest_part_keeps_the_id=("if (mass <= most) continue;", "if (most > 0) continue;"),
        a_flicker_is_shown=("is_sure || has_both_edges(tracks, object.sum.lead)", "true"),
        own_unsupported_events_hide=(" && !has_edges_apart(tracks, object.sum.lead)", ""),
        noise_everywhere_hides=(" - noise.rate_hz());", ");"),
        last_part_says_whether_it_is_quiet=(
            "std::min(quiet_us, age_us(now, newest))",
            "age_us(now, newest)",
        ),
    ),
    *in_file(
        SOURCE + "algorithms/motion/background_motion.cpp",
        "algorithms",
        textured_thing_is_the_ground=("equation.weight /= counts_[equation.cell]", ""),
        known_where_nothing_fits=("!is_fitted || std::abs", "true || std::abs"),
        known_from_half_of_the_frame=("some >= 13 && many", "many"),
    ),
    *in_file(
        SOURCE + "algorithms/motion/motion_regions.cpp",
        "algorithms",
        slow_cells_are_flagged=(" && shift.norm() > min_px_s_ + min_share_ * speed", ""),
        what_is_not_significant_is_flagged=("sums.gain(shift) > kSignificant && ", ""),
        a_cell_is_a_region=("kFewestCells = 5", "kFewestCells = 1"),
    ),
    *in_file(
        SOURCE + "algorithms/motion/region_tracks.cpp",
        "algorithms",
        farthest_pair_first=("a.distance < b.distance", "a.distance > b.distance"),
        a_new_track_may_miss=("(track.is_listed() ? kMostMisses : 0)", "kMostMisses"),
        unknown_is_independent=("is_known ? 1.0 : -1.0", "1.0"),
    ),
    *in_file(
        SOURCE + "algorithms/cluster_outline.cpp",
        "algorithms",
        the_axes_are_of_one_deviation=("2 * solver.eigenvalues()", "solver.eigenvalues()"),
        the_angle_is_that_of_the_minor_axis=("eigenvectors().col(1)", "eigenvectors().col(0)"),
        an_axis_points_to_either_side=("std::copysign(1.0, major.x())", "1.0"),
        rounding_makes_an_axis_nan=(".cwiseMax(0)", ""),
    ),
    *in_file(
        SOURCE + "formats/encoder.cpp",
        "formats",
        row_never_written=(
            "to += event.y != state.y ? kWord : 0;",
            "to += event.y < state.y ? kWord : 0;",
        ),
        low_bits_of_time_left_out=(
            "to += event.t != state.t ? kWord : 0;",
            "to += event.t > state.t + 1 ? kWord : 0;",
        ),
        high_bits_of_time_cut=("kTimeHigh, t >> 12 & 0xfff)", "kTimeHigh, t >> 12 & 0x7ff)"),
        mark_beyond_what_readers_unwrap=(
            "kReach = std::int64_t{1} << 22;",
            "kReach = std::int64_t{1} << 24;",
        ),
        gap_of_127_in_one_byte=("kReach = 127;", "kReach = 128;"),
        back_step_encoded=(
            "bool held = event.t >= last &&",
            "bool held = event.t >= std::min(last, Format::kMinTime) &&",
        ),
        refused_event_misnumbered=(
            "state.events += i;\n    if (i > 0) state.last_t = last;",
            "if (i > 0) state.last_t = last;",
        ),
    ),
    *in_file(
        SOURCE + "formats/columns.cpp",
        "formats",
        a_field_is_taken_twice=("ToAddress{}(top, to.y)", "ToAddress{}(left, to.y)"),
        bad_fields_pass=("good &= to_us", "good |= to_us"),
    ),
    *in_file(
        SOURCE + "formats/plain_line.hpp",
        "formats",
        polarity_of_two_digits_cut=("(p_end - y_end == 2)", "(p_end - y_end >= 2)"),
        any_character_separates=("is_separator(separator) & ", ""),
        long_times_cut=("if (count > 8) {", "if (count > 9) {"),
    ),
    *in_file(
        SOURCE + "formats/records.hpp",
        "formats",
        record_without_room_is_passed=("if (!take_one(word)) break;", "take_one(word);"),
        record_that_ends_in_the_next_piece_is_read_twice=("    cut.size = 0;\n", ""),
    ),
    *in_file(
        SOURCE + "formats/aedat2.cpp",
        "formats",
        wrap_of_aedat2_forgotten=(
            "t = unwrapped(t, static_cast<std::uint32_t>(word), std::int64_t{1} << 32);",
            "t = static_cast<std::uint32_t>(word);",
        ),
        trigger_without_room_is_not_awaited=("!out.has_room_for_a_trigger()", "false"),
    ),
    *in_file(
        SOURCE + "formats/aedat3.cpp",
        "formats",
        overflows_of_the_packet_ignored=("static_cast<std::int64_t>(header.overflows) << 31", "0"),
        bad_bytes_end_with_any_packet=(" || (lost_ && header.type != kPolarity)", ""),
    ),
    *in_file(
        SOURCE + "formats/atis40.cpp",
        "formats",
        row_240_marks_no_time=("event ? 0 : kMarkUs", "event ? 0 : 0"),
    ),
    *in_file(
        SOURCE + "runner/tiled.cpp",
        "runner",
        a_step_back_between_two_shares=("before > 0 ? events_[before - 1].t : ", ""),
        an_event_outside_the_frame_is_the_one_before=("!has(events_[before - 1])", "false"),
        a_long_step_counts_as_it_is=("> EventClock::kLongestStep_us", "> UINT64_MAX - 1"),
        a_jagged_package_is_taken_twice=(
            "if (is_jagged_.load(std::memory_order_relaxed)) return;",
            "",
        ),
    ),
    *in_file(
        SOURCE + "formats/event_stream.cpp",
        "formats",
        padding_takes_time=("(word & 1) * 127", "127"),
    ),
    *in_file(
        SOURCE + "formats/words.hpp",
        "formats",
        every_step_back_is_a_wrap=("last - t > range / 2", "last > t"),
        a_cut_word_without_room_is_lost=(
            "if (decode(cut.bytes.data(), 1) == 0) return 0;",
            "decode(cut.bytes.data(), 1);",
        ),
    ),
    *in_file(
        SOURCE + "formats/evt21.cpp",
        "formats",
        legacy_halves_not_swapped=("std::rotl(word, 32)", "word"),
    ),
    *in_file(
        SOURCE + "formats/evt3.cpp",
        "formats",
        a_repeated_time_high_sets_time_low=("if (word == high_word_) return;", ""),
        each_vector_moves_the_base_by_12=("(word >> 12 == kVect12 ? 12 : 8)", "12"),
    ),
    *in_file(
        SOURCE + "formats/dat.cpp",
        "formats",
        epoch_of_dat_forgotten=("t_ = t;", "t_ = t & (kDatRange - 1);"),
    ),
    *in_file(
        SOURCE + "formats/packets.cpp",
        "formats",
        ns_of_the_time_base_lost=("whole_us(rest_ns + (word", "whole_us((word"),
        a_small_step_back_of_libcaer_wraps=("if (last - stamp > kLibcaerRange / 2) ", ""),
        a_vector_of_libcaer_cmp_stays=("(now.base_y + 8) & 0xffff", "now.base_y"),
        x_of_an_aligned_event_comes_late=("record - forward", "record"),
    ),
]
