!> What the tests of beliefs have in common: the simulator of a case, and a density wave near the period of the rods.
module belief_fixture
    use vocabulary
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_estimation_options, only: estimation_options_t
    implicit none
    private
    public :: simulator_of, WAVE_NEAR_RODS

    type(density_wave_t), parameter :: WAVE_NEAR_RODS = density_wave_t(0.003_dp, 12.0_dp, 0.0_dp)
    !! Its period is near the 10 s of the rods, so that it takes up a part of what a wrong delay does; with that of the
    !! cases, 19.9 s, it takes up little

contains

    subroutine simulator_of(name, simulator, options, error, wave)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        type(error_type), allocatable, intent(inout) :: error
        type(density_wave_t), intent(in), optional :: wave  !! In place of the case's

        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure

        call find_calibration(name, calibration, failure)
        if (present(wave)) calibration%case%density_wave = wave
        if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
        call check_passes(error, failure)
        options = calibration%options
    end subroutine simulator_of
end module belief_fixture
