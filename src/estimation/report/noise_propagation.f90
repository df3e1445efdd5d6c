!> How the instruments' true noise passes through a weighted least-squares fit whose weights are not
!> the noise's: covariance of x = N^-1 G e is N^-1 G E{e e^T} G^T N^-1 (the "sandwich").
module gracecg_estimation_noise_propagation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, N_POLES
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_estimation_attitude_fit, only: kinematic_partials
    use gracecg_estimation_interpolation, only: interpolation_t
    use gracecg_estimation_star_attitude, only: star_attitude_t
    use gracecg_estimation_solution, only: solution_t, STATE, STATE_NAMES, STATE_OFFSET, STATE_DRIFT, STATE_BIAS, STATE_RATE
    use gracecg_estimation_fit_record, only: fit_record_t, record_covariance, NOISE_SOURCES
    implicit none
    private
    public :: propagate_noise, stationary_noise_covariance, accelerometer_noise_covariance, star_noise_covariance

contains

    !> Puts the covariance of the state into a solution, and into a record if there is one: that by the accelerometer's
    !> noise, each axis with its spectrum (3-2), and that by another source.
    subroutine propagate_noise(knowledge, gain, epoch, by_other, other, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: gain(:, :)              !! N^-1 W H of the accelerometer: STATE x (3 times samples)
        integer, intent(in) :: epoch(:)                 !! Increasing index of each sample
        real(dp), intent(in) :: by_other(STATE, STATE)  !! Covariance by the other source
        integer, intent(in) :: other                    !! STAR_CAMERA_NOISE or A_PRIORI_KNOWLEDGE
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        integer, parameter :: RECORDED(12) = [STATE_OFFSET, STATE_DRIFT, STATE_BIAS, STATE_RATE]
        real(dp) :: by_axis(STATE, STATE, 3), by_source(3, 3, NOISE_SOURCES)

        call accelerometer_noise_covariance(knowledge, gain, epoch, solution%state_covariance, error, by_axis)
        if (allocated(error)) return
        solution%state_covariance = solution%state_covariance + by_other
        solution%covariance = solution%state_covariance(STATE_OFFSET, STATE_OFFSET)
        if (.not. present(record)) return
        by_source = 0
        by_source(:, :, :3) = by_axis(STATE_OFFSET, STATE_OFFSET, :)
        by_source(:, :, other) = by_other(STATE_OFFSET, STATE_OFFSET)
        call record_covariance(STATE_NAMES(RECORDED), solution%state_covariance(RECORDED, RECORDED), STATE_OFFSET, by_source, &
                               record)
    end subroutine propagate_noise

    !> Covariance by the accelerometer's noise.
    subroutine accelerometer_noise_covariance(knowledge, gain, epoch, covariance, error, by_axis)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: gain(:, :)              !! N^-1 W H: parameters x (3 times samples)
        integer, intent(in) :: epoch(:)                 !! Increasing index of each sample
        real(dp), intent(out) :: covariance(:, :)       !! Parameters x parameters
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(out), optional :: by_axis(:, :, :) !! The part of each axis: n x n x 3

        type(coloured_noise_t) :: noise
        real(dp) :: part(size(covariance, 1), size(covariance, 2))
        integer :: axis

        covariance = 0
        do axis = 1, 3
            noise = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            part = stationary_noise_covariance(gain(:, axis::3), epoch, noise)
            covariance = covariance + part
            if (present(by_axis)) by_axis(:, :, axis) = part
        end do
    end subroutine accelerometer_noise_covariance

    !> sum over pairs of epochs of g_i r(|k_i - k_j|) g_j^T for one accelerometer axis.
    !>
    !> The noise is a white sequence and processes of the first order with r(k) = s phi^k. What the samples before
    !> epoch j contribute, sum_(i<j) g_i phi^(k_j - k_i), follows from what those before the epoch ahead did, as the
    !> process itself would: one pass, whatever the length.
    pure function stationary_noise_covariance(gain, epoch, noise) result(covariance)
        real(dp), intent(in) :: gain(:, :)              !! N^-1 W H: parameters x samples
        integer, intent(in) :: epoch(:)                 !! Increasing index k of each sample
        type(coloured_noise_t), intent(in) :: noise     !! Of one axis
        real(dp) :: covariance(size(gain, 1), size(gain, 1))

        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES), decay(N_POLES)
        real(dp) :: past(size(gain, 1), N_POLES), passed(size(gain, 1))
        integer :: j, p, pole, gap

        call noise%markov_form(white_variance, correlation, variance)
        covariance = 0
        past = 0
        gap = 0
        do j = 1, size(epoch)
            if (j > 1) then
                if (epoch(j) - epoch(j - 1) /= gap) then
                    gap = epoch(j) - epoch(j - 1)
                    decay = correlation**gap
                end if
                do pole = 1, N_POLES
                    past(:, pole) = decay(pole)*(past(:, pole) + gain(:, j - 1))
                end do
            end if
            ! half of the epoch with itself: the other half comes with the transpose
            passed = gain(:, j)*((white_variance + sum(variance))/2)
            do pole = 1, N_POLES
                passed = passed + variance(pole)*past(:, pole)
            end do
            do p = 1, size(passed)
                covariance(:, p) = covariance(:, p) + passed*gain(p, j)
            end do
        end do
        covariance = covariance + transpose(covariance)
    end function stationary_noise_covariance

    !> The same for white star-camera noise that reaches the estimator through linearly interpolated
    !> quaternions (CSR-TM-00-01 section 4.5): neighbouring pseudo-observations share samples.
    pure function star_noise_covariance(gain, source, sigma, mounting, stars) result(covariance)
        real(dp), intent(in) :: gain(:, :, :)           !! N^-1 W H: parameters x 4 x pseudo-observations
        type(interpolation_t), intent(in) :: source(:)  !! Origin of each pseudo-observation
        real(dp), intent(in) :: sigma(3)                !! About the axes of either camera, rad
        real(dp), intent(in) :: mounting(4, HEADS)      !! Quaternions body to camera
        type(star_attitude_t), intent(in) :: stars
        real(dp) :: covariance(size(gain, 1), size(gain, 1))

        real(dp) :: sample_gain(size(gain, 1), 4, size(stars%quaternion, 2))
        real(dp) :: to_body_sigma(3, 3, HEADS), spread_gain(size(gain, 1), 3)
        integer :: i, s, head

        sample_gain = 0
        do i = 1, size(source)
            s = source(i)%first
            sample_gain(:, :, s) = sample_gain(:, :, s) + (1 - source(i)%fraction)*gain(:, :, i)
            sample_gain(:, :, s + 1) = sample_gain(:, :, s + 1) + source(i)%fraction*gain(:, :, i)
        end do
        ! a small turn theta (4-68) in body axes changes q by kinematic_partials(q) theta; theta in body
        ! axes is the transposed mounting times theta in camera axes
        do head = 1, HEADS
            to_body_sigma(:, :, head) = transpose(rotation_matrix(mounting(:, head)))*spread(sigma, 1, 3)
        end do
        covariance = 0
        do s = 1, size(stars%quaternion, 2)
            spread_gain = matmul(sample_gain(:, :, s), matmul(kinematic_partials(stars%quaternion(:, s)), &
                                                              to_body_sigma(:, :, stars%head(s))))
            covariance = covariance + matmul(spread_gain, transpose(spread_gain))
        end do
    end function star_noise_covariance
end module gracecg_estimation_noise_propagation
