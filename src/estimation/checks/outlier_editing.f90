!> Editing of samples that do not belong to a fit: spikes of the accelerometer, wrong quaternions.
!>
!> A sample is judged by how far it is from the fit, a normalised residual or its square. The limit is in units
!> of the noise or, if that is larger, of what is usual among the residuals (from their median): forces
!> that the model leaves out enlarge all residuals and are no fault of single samples.
module gracecg_estimation_outlier_editing
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_statistics, only: median_of
    use gracecg_base_coloured_noise, only: noise_spectrum_t
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_spike_screen, only: is_spike
    implicit none
    private
    public :: leave_out_worst, decide_anew, spikes_of, report_edited
    public :: MEDIAN_OF_ONE, MEDIAN_OF_THREE

    !> Medians of |x|, x of the standard normal distribution, and of the length of a vector of three such
    real(dp), parameter :: MEDIAN_OF_ONE = 0.67449_dp, MEDIAN_OF_THREE = 1.53817_dp

contains

    !> Leaves out the worst samples. A great outlier pulls the fit and so the residuals of good samples; a
    !> round therefore leaves out only what exceeds half of the worst (what the fit shares out among many
    !> samples is smaller), and the fit is to be repeated.
    subroutine leave_out_worst(deviation, limit, expected_median, kept, changed)
        real(dp), intent(in) :: deviation(:)        !! Absolute values of normalised residuals, (samples)
        real(dp), intent(in) :: limit               !! Of a deviation
        real(dp), intent(in) :: expected_median     !! Of the deviations, if they are noise
        logical, intent(inout) :: kept(:)           !! (samples)
        logical, intent(inout) :: changed           !! Set if another fit is needed

        real(dp) :: worst, most

        worst = maxval(deviation, mask=kept)
        if (worst <= limit) return
        most = robust_limit(limit, pack(deviation, kept), expected_median)
        if (worst <= most) return
        changed = .true.
        kept = kept .and. deviation <= max(most, worst/2)
    end subroutine leave_out_worst

    !> Decides anew which samples are kept, where each is compared with what all others say.
    subroutine decide_anew(deviation, limit, expected_median, kept, changed)
        real(dp), intent(in) :: deviation(:)        !! Normalised squares, (samples)
        real(dp), intent(in) :: limit               !! Of a deviation
        real(dp), intent(in) :: expected_median     !! Of the deviations, if they are noise
        logical, intent(inout) :: kept(:)           !! (samples)
        logical, intent(inout) :: changed           !! Set if another fit is needed

        logical :: now(size(kept))

        now = deviation <= robust_limit(limit, deviation, expected_median)
        changed = changed .or. any(now .neqv. kept)
        kept = now
    end subroutine decide_anew

    real(dp) function robust_limit(limit, deviation, expected_median)
        real(dp), intent(in) :: limit, deviation(:), expected_median

        robust_limit = limit*max(1.0_dp, median_of(deviation)/expected_median)
    end function robust_limit

    !> Samples of the accelerometer that are so far from their neighbours, whatever the fit, that no fit comes back from them.
    pure function spikes_of(data, noise) result(spikes)
        type(fitting_data_t), intent(in) :: data
        type(noise_spectrum_t), intent(in) :: noise(3)      !! Of the axes
        logical :: spikes(3, size(data%acceleration, 2))

        real(dp), parameter :: FAR = 1e3_dp     ! Standard deviations, chosen: such spikes are not of the noise, or the satellite
        integer :: axis

        do axis = 1, 3
            spikes(axis, :) = is_spike(data%acceleration(axis, :), &
                                       sqrt(noise(axis)%level*noise(axis)%sides/(2*data%interval)), FAR)
        end do
    end function spikes_of

    !> Counts and warns of what was left out. Fails when it is more than a given part of a series: then the fit
    !> is wrong, not the samples.
    subroutine report_edited(data, kept, star_kept, limit, most, edited, warnings, error)
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: kept(:, :)           !! (3, accelerometer samples)
        logical, intent(in) :: star_kept(:)         !! (star-camera samples)
        real(dp), intent(in) :: limit               !! Beyond which a sample is left out, standard deviations
        real(dp), intent(in) :: most                !! Part of a series that may be left out
        integer, intent(out) :: edited(2)           !! Accelerometer (each axis counts), star camera
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        edited = [count(.not. kept), count(.not. star_kept)]
        do axis = 1, 3
            call tell('accelerometer, axis '//AXES(axis), data%accelerometer_epoch*data%interval, kept(axis, :))
        end do
        call tell('star camera', data%stars%time, star_kept)

    contains

        subroutine tell(name, times, used)
            character(*), intent(in) :: name
            real(dp), intent(in) :: times(:)
            logical, intent(in) :: used(:)

            character(:), allocatable :: text
            integer :: n

            n = count(.not. used)
            if (n == 0 .or. allocated(error)) return
            text = name//': '//integer_text(n)//' of '//integer_text(size(used))//' samples are more than '// &
                   number_text(limit)//' standard deviations off the fit, the first at '// &
                   number_text(times(findloc(used, .false., 1)))//' s'
            if (n > most*size(used)) then
                call fail(error, text//'; so many are not faults of single samples: check setup, units '// &
                          'and noise levels')
            else
                call append(warnings, text//'; they are left out')
            end if
        end subroutine tell
    end subroutine report_edited
end module gracecg_estimation_outlier_editing
