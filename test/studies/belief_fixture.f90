!> What the tests of beliefs have in common: the simulator of a case, and a density wave near the period of the rods.
module belief_fixture
    use vocabulary
    use calibrations
    use gracecg_environment_thermosphere, only: density_wave_t
    implicit none
    private
    public :: simulator_of, WAVE_NEAR_RODS

    type(density_wave_t), parameter :: WAVE_NEAR_RODS = density_wave_t(0.003_dp, 12.0_dp, 0.0_dp)
    !! Its period is near the 10 s of the rods, so that it takes up a part of what a wrong delay does; with that of the
    !! cases, 19.9 s, it takes up little

contains

    subroutine simulator_of(name, simulator, options, wave)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        type(density_wave_t), intent(in), optional :: wave  !! In place of the case's
        type(calibration_t) :: calibration

        call take_calibration(name, calibration)
        if (present(wave)) calibration%case%density_wave = wave
        call make_simulator(calibration%case, simulator)
        options = calibration%options
    end subroutine simulator_of
end module belief_fixture
