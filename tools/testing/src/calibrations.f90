!> What tests of calibrations have in common: the types, and cases, simulators and observations that they need and do not test;
!> where one cannot be had, the run ends. Test modules use it whole.
module calibrations
    use vocabulary
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: find_case, REPORT_CASE_NAMES
    use gracecg_simulation_case_models, only: build_dynamics
    use gracecg_simulation_dynamics, only: satellite_dynamics_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, propagate_case, observe, &
        observe_without_noise, error_switches_t, new_switched_simulator
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset, ESTIMATOR_NAMES, REPORT_ESTIMATORS
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_site, only: planned_arc_t, new_planned_arc
    implicit none
    private
    public :: case_t, simulator_t, observation_set_t, calibration_t, estimation_options_t, solution_t
    public :: REPORT_CASE_NAMES, ESTIMATOR_NAMES, REPORT_ESTIMATORS, observe_without_noise, sigmas
    public :: estimate_offset, estimate_fails, estimate_refused
    public :: take_case, take_calibration, make_simulator, make_observations, make_dynamics, make_arc, make_orbit, make_plan

    !> make_simulator(source, simulator) of a case or of the name of one; make_simulator(case, switches, simulator).
    interface make_simulator
        module procedure simulator_of_case, simulator_of_name, switched_simulator
    end interface make_simulator

    !> make_observations(source, seed, run, observations[, only_used_head]) of a simulator, a case or the name of a case.
    interface make_observations
        module procedure observations_of_simulator, observations_of_case, observations_of_name
    end interface make_observations

contains

    !> A built-in case, or that of a file.
    subroutine take_case(name, case)
        character(*), intent(in) :: name
        type(case_t), intent(out) :: case
        type(error_t), allocatable :: failure

        call find_case(trim(name), case, failure)
        call need(failure)
    end subroutine take_case

    !> The case and the options of its estimates.
    subroutine take_calibration(name, calibration)
        character(*), intent(in) :: name
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable :: failure

        call find_calibration(trim(name), calibration, failure)
        call need(failure)
    end subroutine take_calibration

    subroutine simulator_of_case(case, simulator)
        type(case_t), intent(in) :: case
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable :: failure

        call new_simulator(case, simulator, failure)
        call need(failure)
    end subroutine simulator_of_case

    subroutine simulator_of_name(name, simulator)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(case_t) :: case

        call take_case(name, case)
        call make_simulator(case, simulator)
    end subroutine simulator_of_name

    !> Without some errors of the simulation.
    subroutine switched_simulator(case, switches, simulator)
        type(case_t), intent(in) :: case
        type(error_switches_t), intent(in) :: switches
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable :: failure

        call new_switched_simulator(case, switches, simulator, failure)
        call need(failure)
    end subroutine switched_simulator

    !> The forces and torques of a case.
    subroutine make_dynamics(case, dynamics)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(out) :: dynamics
        type(error_t), allocatable :: failure

        call build_dynamics(case, dynamics, failure)
        call need(failure)
    end subroutine make_dynamics

    !> The true arc of a case.
    subroutine make_arc(case, arc)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable :: failure

        call propagate_case(case, arc, failure)
        call need(failure)
    end subroutine make_arc

    !> The orbit of a case over a revolution.
    subroutine make_orbit(case, orbit, interval)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(out) :: orbit
        real(dp), intent(in), optional :: interval      !! s, as `new_nominal_orbit` has it
        type(error_t), allocatable :: failure

        call new_nominal_orbit(case, orbit, failure, interval=interval)
        call need(failure)
    end subroutine make_orbit

    !> The arc of a case as a planner sees it.
    subroutine make_plan(case, planned)
        type(case_t), intent(in) :: case
        type(planned_arc_t), intent(out) :: planned
        type(error_t), allocatable :: failure

        call new_planned_arc(case, planned, failure)
        call need(failure)
    end subroutine make_plan

    subroutine observations_of_simulator(simulator, seed, run, observations, only_used_head)
        type(simulator_t), intent(in) :: simulator
        integer, intent(in) :: seed, run
        type(observation_set_t), intent(out) :: observations
        logical, intent(in), optional :: only_used_head     !! As `observe` has it
        type(error_t), allocatable :: failure

        call observe(simulator, seed, run, observations, failure, only_used_head)
        call need(failure)
    end subroutine observations_of_simulator

    subroutine observations_of_case(case, seed, run, observations, only_used_head)
        type(case_t), intent(in) :: case
        integer, intent(in) :: seed, run
        type(observation_set_t), intent(out) :: observations
        logical, intent(in), optional :: only_used_head
        type(simulator_t) :: simulator

        call make_simulator(case, simulator)
        call make_observations(simulator, seed, run, observations, only_used_head)
    end subroutine observations_of_case

    subroutine observations_of_name(name, seed, run, observations, only_used_head)
        character(*), intent(in) :: name
        integer, intent(in) :: seed, run
        type(observation_set_t), intent(out) :: observations
        logical, intent(in), optional :: only_used_head
        type(simulator_t) :: simulator

        call make_simulator(name, simulator)
        call make_observations(simulator, seed, run, observations, only_used_head)
    end subroutine observations_of_name

    !> Estimates, which must succeed; is there an error now, or was there before, so that a test cannot go on?
    logical function estimate_fails(error, algorithm, observations, options, solution, record)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(fit_record_t), intent(out), optional :: record
        type(error_t), allocatable :: failure

        call estimate_offset(trim(algorithm), observations, options, solution, failure, record)
        estimate_fails = failed(error, failure)
    end function estimate_fails

    !> Estimates, which must fail with every one of the parts in the message.
    subroutine estimate_refused(error, algorithm, observations, parts, options)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: algorithm, parts
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in), optional :: options     !! Left out: as they are by themselves
        type(estimation_options_t) :: used
        type(solution_t) :: solution
        type(error_t), allocatable :: failure

        if (present(options)) used = options
        call estimate_offset(trim(algorithm), observations, used, solution, failure)
        call check_fails(error, failure, parts)
    end subroutine estimate_refused

    !> Standard deviations of d.
    pure function sigmas(covariance)
        real(dp), intent(in) :: covariance(:, :)        !! d comes first, m^2
        real(dp) :: sigmas(3)

        integer :: i

        sigmas = [(sqrt(covariance(i, i)), i=1, 3)]
    end function sigmas
end module calibrations
