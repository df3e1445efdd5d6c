!> Calibrations that stop when the offset is known: the statistics of many, and what a sample and a plan take.
!>
!> fpm run --example closed_loop --profile release [-- LOOPS [THREADS [WANTED_UM [CASE]]]]. Instructions are those of
!> `valgrind --tool=callgrind`, with one loop, of live_estimate's add and next_seconds' plan.
program closed_loop
    use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_spacecraft_torque_rods, only: SINE
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_live_estimate, only: live_estimate_t, begin_live_estimate
    use gracecg_planning_candidates, only: design_settings_t, candidate_t, rods_of
    use gracecg_planning_next_seconds, only: next_seconds_t, begin_planning
    use gracecg_studies_closed_loop, only: loop_settings_t, loop_t, loop_statistics_t, run_loops, statistics_of_loops
    implicit none

    type(case_t) :: case
    type(error_t), allocatable :: error
    type(loop_settings_t) :: settings
    integer :: loops, threads
    real(dp) :: wanted
    character(20) :: name

    loops = 1000
    threads = 2
    wanted = 20
    name = 'front-3'
    call take(1, loops)
    call take(2, threads)
    call get_command_argument(3, name)
    if (name /= '') read (name, *) wanted
    call get_command_argument(4, name)
    if (name == '') name = 'front-3'
    call report_case(trim(name), case, error)
    call stop_at(error)
    settings%wanted = 1e-6_dp*wanted
    call tell_bytes()
    call run('planned every 10 s')
    if (loops < 2) stop
    settings%real_forces = .true.
    call run('the same under drag and radiation')
    settings%real_forces = .false.
    settings%fixed = rods_of(design_settings_t(), settings%longest, &
                             candidate_t(SINE, settings%longest*[5, 6, 7]/60, amplitude=settings%amplitude))
    call run('rods at 5, 6 and 7 cycles a minute')

contains

    !> An integer argument, if it is given.
    subroutine take(number, value)
        integer, intent(in) :: number
        integer, intent(inout) :: value

        character(20) :: text

        call get_command_argument(number, text)
        if (text /= '') read (text, *) value
    end subroutine take

    !> What an estimate and a planner hold.
    subroutine tell_bytes()
        type(operator_knowledge_t) :: knowledge
        type(live_estimate_t) :: live
        type(next_seconds_t) :: planner

        knowledge = operator_knowledge(case, case%operator)
        knowledge%star_camera_sigma = 1e-5_dp
        call begin_live_estimate(knowledge, case%quaternion, case%angular_velocity, live, error)
        if (.not. allocated(error)) &
            call begin_planning(knowledge, settings%plan_seconds, settings%amplitude, planner, error)
        call stop_at(error)
        write (output_unit, '("estimate: ", i0, " bytes, ", i0, " of them the first samples; planner: ", i0, " manoeuvres in ", &
            &i0, " bytes")') (storage_size(live) + storage_size(live%first)*size(live%first) + 64*(2*size(live%constants%array) + &
            size(live%trajectory%partials) + 20 + size(live%model%upwards)*4))/8, &
            storage_size(live%first)*size(live%first)/8, size(planner%candidates), (storage_size(planner) + &
            storage_size(planner%candidates)*size(planner%candidates) + 64*size(planner%dipole))/8
    end subroutine tell_bytes

    subroutine run(what)
        character(*), intent(in) :: what

        type(loop_t), allocatable :: results(:)
        type(loop_statistics_t) :: s

        call run_loops(case, settings, loops, threads, results, error)
        call stop_at(error)
        if (loops < 2) return
        call statistics_of_loops(results, s, error)
        call stop_at(error)
        write (output_unit, '(a, ": ", i0, " of ", i0, " loops stopped at ", f0.1, " um")') what, s%stopped, s%loops, &
            1e6_dp*settings%wanted
        write (output_unit, '("  mean normalised square ", f7.4, " +- ", f6.4, ", mean error by sigma", 3f8.4)') &
            s%square, s%square_error, s%bias
        write (output_unit, '("  after ", f0.1, " s (", f0.1, " to ", f0.1, ") and ", f0.1, " plans; in all, samples edited ", &
            &i0, ", plans at rest ", i0)') s%time, s%earliest, s%latest, s%plans, s%edited, s%resting
        flush (output_unit)
    end subroutine run

    !> Ends the program with what has failed, if anything.
    subroutine stop_at(failure)
        type(error_t), allocatable, intent(in) :: failure

        if (.not. allocated(failure)) return
        write (error_unit, '(a)') message_of(failure)
        error stop 1
    end subroutine stop_at
end program closed_loop
