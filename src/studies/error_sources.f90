!> The error sources of CSR-TM-00-01 section 6.3 and Figure 6.5: the error of the offset with one of
!> them switched off.
module gracecg_studies_error_sources
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_files_data_table, only: data_table_t
    use gracecg_simulation_simulator, only: simulator_t, error_switches_t, new_switched_simulator
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_monte_carlo, only: error_study_t, study_errors
    implicit none
    private
    public :: error_study_t, study_all_errors, study_switches, STUDY_NAMES, error_table

    !> The five simulations of Figure 6.5, in its order
    character(12), parameter :: STUDY_NAMES(5) = [character(12) :: 'all-noise', 'linear-ng', &
                                                  'no-acc-noise', 'no-sca-noise', 'no-mag-noise']

contains

    !> The switches of one of STUDY_NAMES; everything acts in one of another name.
    pure function study_switches(name) result(switches)
        character(*), intent(in) :: name    !! One of STUDY_NAMES
        type(error_switches_t) :: switches

        switches%curved_force = name /= 'linear-ng'
        switches%accelerometer_noise = name /= 'no-acc-noise'
        switches%star_camera_noise = name /= 'no-sca-noise'
        switches%magnetometer_noise = name /= 'no-mag-noise'
        switches%magnetometer_bias = name /= 'no-mag-noise'
    end function study_switches

    !> All simulations of STUDY_NAMES, one after the other, in each of which only the error sources of the study act. Fails as
    !> `new_simulator` and `study_errors` do.
    subroutine study_all_errors(calibration, algorithm, seed, runs, threads, studies, error, progress)
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithm   !! One of ESTIMATOR_NAMES
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads  !! Runs of each Monte Carlo; in parallel
        type(error_study_t), intent(out) :: studies(:)  !! In the order of STUDY_NAMES
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(simulator_t) :: simulator
        integer :: i

        call expect_pieces(progress, size(STUDY_NAMES)*runs, 'runs')
        do i = 1, size(STUDY_NAMES)
            call tell(progress, 'error sources, '//trim(STUDY_NAMES(i)))
            call new_switched_simulator(calibration%case, study_switches(STUDY_NAMES(i)), simulator, error)
            if (.not. allocated(error)) call study_errors(simulator, algorithm, calibration%options, seed, runs, threads, &
                                                          studies(i), error, progress)
            if (allocated(error)) return
        end do
    end subroutine study_all_errors

    !> Figure 6.5: RMS errors with one error source off at a time, beside what theory expects.
    function error_table(studies) result(table)
        type(error_study_t), intent(in) :: studies(:)       !! In the order of STUDY_NAMES
        type(data_table_t) :: table

        integer :: i, axis

        call table%column('source', 'a', 'source')
        call table%column('axis', 'a', 'axis')
        call table%column('runs')
        call table%column('rms_mm', 'f10.5', 'here')
        call table%column('predicted_mm', 'f10.5', 'theory')
        do i = 1, size(studies)
            do axis = 1, 3
                call table%add(STUDY_NAMES(i), AXES(axis))
                call table%add([real(studies(i)%runs, dp), [studies(i)%rms(axis), studies(i)%predicted(axis)]/MILLIMETRE])
            end do
        end do
    end function error_table
end module gracecg_studies_error_sources
