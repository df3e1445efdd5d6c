!> Editing of samples that do not belong to the fit: spikes of the accelerometer, wrong quaternions.
!>
!> A sample is judged by its normalised residual: of the accelerometer, the innovation of the whitening
!> filter, which a spike moves by its whole size; of the star camera, the length of the three angles in
!> units of their noise. The limit is six standard deviations, where the standard deviation is that of
!> the noise or, if that is larger, a robust one of the residuals (from their median): forces that
!> the model leaves out enlarge all residuals and are no fault of single samples. A great outlier pulls
!> the fit and so the residuals of good samples; a round therefore leaves out only what exceeds half
!> of the worst (what the fit shares out among many samples is smaller), and the fit is repeated.
module gracecg_estimation_outlier_editing
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_statistics, only: median_of
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    implicit none
    private
    public :: edit_samples, report_edited

    real(dp), parameter :: LIMIT = 6                !! Standard deviations; 2e-9 of Gaussian noise is beyond
    real(dp), parameter :: MEDIAN_OF_ONE = 0.67449_dp   !! Of |x|, x of the standard normal distribution
    real(dp), parameter :: MEDIAN_OF_THREE = 1.53817_dp !! Of the length of a vector of three such
    real(dp), parameter :: MOST = 0.25_dp           !! Part of a series that may be left out

contains

    !> Leaves out what is too far from the fit; the residuals must be those of the present state.
    !> `changed` tells whether another fit is needed.
    subroutine edit_samples(problem, changed)
        type(whitened_problem_t), intent(inout) :: problem
        logical, intent(out) :: changed    !! Another set of samples than before

        real(dp) :: normalised(size(problem%star_kept))
        integer :: axis, i

        changed = .false.
        do axis = 1, 3
            call leave_out(abs(problem%whiteners(axis)%innovations(problem%acceleration_residual(axis, :))), &
                           MEDIAN_OF_ONE, problem%acceleration_kept(axis, :), changed)
        end do
        do i = 1, size(normalised)
            normalised(i) = norm2(problem%star_angles(:, i)/problem%noise%star_camera_sigma)
        end do
        call leave_out(normalised, MEDIAN_OF_THREE, problem%star_kept, changed)
    end subroutine edit_samples

    subroutine leave_out(normalised, expected_median, kept, changed)
        real(dp), intent(in) :: normalised(:)       !! Absolute values
        real(dp), intent(in) :: expected_median
        logical, intent(inout) :: kept(:)
        logical, intent(inout) :: changed

        real(dp) :: worst, most

        worst = maxval(normalised, mask=kept)
        if (worst <= LIMIT) return
        most = LIMIT*max(1.0_dp, median_of(pack(normalised, kept))/expected_median)
        if (worst <= most) return
        changed = .true.
        kept = kept .and. normalised <= max(most, worst/2)
    end subroutine leave_out

    !> Warns of what was left out. Fails when it is more than a quarter of a series: then the fit is
    !> wrong, not the samples.
    subroutine report_edited(problem, edited, warnings, error)
        type(whitened_problem_t), intent(in) :: problem
        integer, intent(out) :: edited(2)           !! Accelerometer (each axis counts), star camera
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        edited = [count(.not. problem%acceleration_kept), count(.not. problem%star_kept)]
        do axis = 1, 3
            associate (epoch => problem%data%accelerometer_epoch)
                call tell('accelerometer, axis '//AXES(axis), epoch*problem%model%interval, &
                          problem%acceleration_kept(axis, :))
            end associate
        end do
        call tell('star camera', problem%data%stars%time, problem%star_kept)

    contains

        subroutine tell(name, times, kept)
            character(*), intent(in) :: name
            real(dp), intent(in) :: times(:)
            logical, intent(in) :: kept(:)

            character(:), allocatable :: text
            integer :: n

            n = count(.not. kept)
            if (n == 0 .or. allocated(error)) return
            text = name//': '//integer_text(n)//' of '//integer_text(size(kept))//' samples are more than '// &
                   'six standard deviations off the fit, the first at '// &
                   number_text(times(findloc(kept, .false., 1)))//' s'
            if (n > MOST*size(kept)) then
                call fail(error, text//'; so many are not faults of single samples: check setup, units '// &
                          'and noise levels')
            else
                call append(warnings, text//'; they are left out')
            end if
        end subroutine tell
    end subroutine report_edited
end module gracecg_estimation_outlier_editing
