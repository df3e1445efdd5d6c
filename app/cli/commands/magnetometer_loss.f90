!> gracecg magnetometer-loss: Figure 6.6 of CSR-TM-00-01, the field model in place of the magnetometer.
module gracecg_cli_magnetometer_loss
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_environment_magnetic_storm, only: storm_field_deviation
    use gracecg_studies_magnetometer_loss, only: field_study_t, study_loss_of_cases, field_table, field_settings, &
        MODEL_FIELD_ERROR
    use gracecg_cli_work
    implicit none
    private
    public :: declare_magnetometer_loss, run_magnetometer_loss

    real(dp), parameter :: REPORT_FIELD_ERROR = anint(MODEL_FIELD_ERROR/NANOTESLA)  !! nT
    real(dp), parameter :: MOST_FIELD_ERROR = 1e5_dp    !! nT

contains

    !> Arguments and help of `gracecg magnetometer-loss`.
    subroutine declare_magnetometer_loss(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('magnetometer-loss', '[CASE ...]', 0, MOST_CASES, &
                                'The RMS error of the CG offset when the magnetometer has failed and the '// &
                                'field of the spherical harmonic model takes its place, as in Figure 6.6 of '// &
                                'CSR-TM-00-01: ASCFEST and ASCREST, for the cases named or, as in the report, '// &
                                'for cases 2 and 3 of the front satellite. The model is wrong by a '// &
                                'constant vector in body axes, drawn for every run.', &
                                'gracecg magnetometer-loss front-2 back-2 --runs 20')
        call add_study_options(arguments, '--cases --runs', runs='100')
        call arguments%add_option('--field-error', 'NT', 'standard deviation of the model''s error on each axis, nT; the '// &
                                  'report''s unless told', default=real_text(REPORT_FIELD_ERROR))
        call arguments%add_option('--kp', 'KP', 'in its place: that of a geomagnetic index Kp, 0 to 9, by (6.1) of '// &
                                  'the report, 42 nT at 2.5')
        call add_study_options(arguments, '--seed --threads --out --format --options')
    end subroutine declare_magnetometer_loss

    !> The work of `gracecg magnetometer-loss`.
    subroutine run_magnetometer_loss(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        type(field_study_t), allocatable :: studies(:)
        type(results_t) :: results
        character(:), allocatable :: heading
        real(dp) :: deviation, kp       ! nT, -

        call arguments%get('--field-error', deviation, misuse, low=0.0_dp, high=MOST_FIELD_ERROR, unit='nT')
        call refuse_if(arguments%has('--kp') .and. arguments%has('--field-error'), &
                       '--kp and --field-error both say how wrong the field model is: give one', misuse)
        kp = 0
        call arguments%get('--kp', kp, misuse, low=0.0_dp, high=9.0_dp)
        if (arguments%has('--kp')) deviation = storm_field_deviation(kp)/NANOTESLA
        call take_study(arguments, 'front-2,front-3', console, study, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        call study_loss_of_cases(study%calibrations, deviation*NANOTESLA, study%seed, study%runs, study%threads, studies, &
                                 error, console)
        if (allocated(error)) return
        heading = 'RMS error of the CG offset, mm: '//integer_text(study%runs)//' runs; error of the field model '// &
                  rounded_text(deviation, 6)//' nT on each axis'
        if (arguments%has('--kp')) heading = heading//', by (6.1) at Kp = '//real_text(kp)
        call console%paragraph(heading)
        call console%table(field_table(studies))
        call results%open('magnetometer-loss')
        call results%member('seed', study%seed)
        call results%member('field_error_nt', deviation)
        call results%publish(field_table(studies), console, error, study%path, trim(field_settings(study%seed, &
            deviation*NANOTESLA)))
    end subroutine run_magnetometer_loss
end module gracecg_cli_magnetometer_loss
