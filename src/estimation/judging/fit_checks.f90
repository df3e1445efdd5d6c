!> Whether the observations fit the manoeuvre: faults that leave a number with a small sigma.
module gracecg_estimation_fit_checks
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: string_t, append
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_estimation_fit_record, only: fit_record_t
    implicit none
    private
    public :: refuse_stuck_axis, check_accelerations, check_torque, estimate_torque_factor
    public :: DOUBTFUL, SIGNIFICANT, MISFITTING, MUCH_NOISE
    public :: judge_torque, judge_noise, RODS_OFF

    !> Said when the manoeuvre has no moment at all
    character(*), parameter :: RODS_OFF = &
        'the torque rods are off all the time: the offset is hardly observable'

    !> A factor farther from 1 is warned of, farther still refused, if it is significant
    real(dp), parameter :: DOUBTFUL = 0.05_dp, WRONG = 0.5_dp
    real(dp), parameter :: SIGNIFICANT = 4      !! In standard deviations
    real(dp), parameter :: OUTLYING = 10        !! Of a residual, in RMS of all
    real(dp), parameter :: MUCH_NOISE = 20
    !! Of the residuals' RMS, in standard deviations of the accelerometer's noise: air drag that is not
    !! a straight line makes up to 5 in the cases of CSR-TM-00-01
    real(dp), parameter :: MISFITTING = 2
    !! RMS of the attitude's residuals, in standard deviations of the star camera's noise: 0.97 to 1.02
    !! in the cases of CSR-TM-00-01

contains

    !> Fails when an accelerometer axis delivers one and the same number all the time.
    subroutine refuse_stuck_axis(data, error)
        type(fitting_data_t), intent(in) :: data
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        do axis = 1, 3
            associate (values => data%acceleration(axis, :))
                if (any(abs(values - values(1)) > 0)) cycle
                call fail(error, 'accelerometer: all samples of axis '//AXES(axis)//' are '// &
                          number_text(values(1))//' m/s^2: the axis does not measure')
                return
            end associate
        end do
    end subroutine refuse_stuck_axis

    !> Examines the residuals of the accelerometer after the fit. Fails when a single sample is far
    !> from the fit: a spike pulls the offset without enlarging its sigma. Warns where all residuals are
    !> much larger than the noise: a wrong unit, many spikes, forces that the fit does not model.
    subroutine check_accelerations(knowledge, data, residuals, warnings, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        real(dp), intent(in) :: residuals(:)        !! x, y, z of each sample in turn, m/s^2
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp) :: rms, deviation(1)
        integer :: axis, worst

        do axis = 1, 3
            associate (left => residuals(axis::3))
                rms = norm2(left)/sqrt(real(size(left), dp))
                worst = maxloc(abs(left), dim=1)
                if (abs(left(worst)) > OUTLYING*rms) then
                    call fail(error, 'accelerometer: the sample of axis '//AXES(axis)//' at '// &
                              number_text(data%accelerometer_epoch(worst)*data%interval)//' s is '// &
                              number_text(left(worst))//' m/s^2 off the fit, '// &
                              number_text(abs(left(worst))/rms)//' times the RMS of all residuals; '// &
                              'if it is a fault, leave the sample out')
                    return
                end if
            end associate
            noise = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            deviation = sqrt(noise%autocovariance([0]))
            if (deviation(1) > 0) call judge_noise(axis, rms, deviation(1), warnings)
        end do
    end subroutine check_accelerations

    !> Warns of residuals that are much larger than the noise.
    subroutine judge_noise(axis, rms, deviation, warnings)
        integer, intent(in) :: axis    !! 1, 2, 3
        real(dp), intent(in) :: rms             !! Of the axis's residuals, m/s^2
        real(dp), intent(in) :: deviation       !! Standard deviation of the noise, m/s^2
        type(string_t), allocatable, intent(inout) :: warnings(:)

        if (rms <= MUCH_NOISE*deviation) return
        call append(warnings, 'accelerometer: the residuals of axis '//AXES(axis)//' have an RMS of '// &
                    number_text(rms)//' m/s^2, '//number_text(rms/deviation)//' times the noise '// &
                    'of the setup: check the unit of the samples; the offset may be wrong')
    end subroutine judge_noise

    !> Compares the magnetic torque m x B of the setup and the magnetometer with the turn that the star
    !> camera saw: rods that did not fire, a wrong sign, a wrong field. Fails when more than half of
    !> the torque is missing or too much; the offset would be off by as much. Warns of less, of a setup
    !> whose rods stay off, and of attitudes that no factor makes fit.
    subroutine check_torque(knowledge, problem, warnings, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        class(attitude_problem_t), intent(in) :: problem    !! After the fit
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! What was found is put there

        real(dp) :: factor, sigma, misfit

        if (.not. any(abs(problem%data%torque) > 0)) then
            call append(warnings, RODS_OFF)
            return
        end if
        call estimate_torque_factor(knowledge, problem, factor, sigma, misfit, error)
        if (allocated(error)) return
        call judge_torque(factor, sigma, misfit, warnings, error, record)
    end subroutine check_torque

    !> What a factor of the magnetic torque that was estimated means.
    subroutine judge_torque(factor, sigma, misfit, warnings, error, record)
        real(dp), intent(in) :: factor, sigma
        !! Of the rods' torque that fits best, and its standard deviation
        real(dp), intent(in) :: misfit      !! RMS of the attitude's residuals in units of their noise
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! Where they are kept

        character(:), allocatable :: found, doubt

        if (present(record)) then
            record%torque_checked = .true.
            record%torque_factor = factor
            record%torque_sigma = sigma
            record%attitude_misfit = misfit
        end if
        doubt = ''
        if (misfit > MISFITTING) then
            doubt = 'the attitudes of the star camera are off the fit, by '//number_text(misfit)// &
                    ' times their noise: faulty samples, or rods that fired otherwise than the setup says'
            call append(warnings, doubt)
            doubt = '; '//doubt
        end if
        if (abs(factor - 1) <= max(DOUBTFUL, SIGNIFICANT*sigma)) return
        found = 'the satellite turned as if the torque of the rods were '//number_text(factor)// &
            ' (sigma '//number_text(sigma)//') times that of setup and magnetic field'
        if (abs(factor - 1) > WRONG) then
            call fail(error, found//': did the rods fire as the setup says?'//doubt)
        else
            call append(warnings, found//'; the offset may be off by as much')
        end if
    end subroutine judge_torque

    !> The factor of the magnetic torque that would fit the attitude best, estimated together with
    !> attitude and angular velocity at the epoch and a constant torque about each axis (air, gravity
    !> gradient: what the fit does not model), by one linear step from the fit. The angles are weighted with the
    !> star camera's noise about its axes (the boresight is worse by far). The standard deviation comes
    !> from the residuals, but is at least that of the star camera's noise: the variance of the samples
    !> is that of the residuals over the mean of (1-g)^2 + g^2 of the interpolation, and
    !> pseudo-observations between the same samples count as one.
    subroutine estimate_torque_factor(knowledge, problem, factor, sigma, misfit, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        class(attitude_problem_t), intent(in) :: problem    !! After the fit
        real(dp), intent(out) :: factor, sigma              !! 1: as it should be; standard deviation
        real(dp), intent(out) :: misfit
        !! RMS of the residuals in standard deviations of the noise; 0 if that is unknown
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: N = 10    ! small angles, angular velocity, constant torque, factor
        real(dp), parameter :: STEP = 1e-2_dp           ! of the factor, for its partials
        real(dp), parameter :: TORQUE_STEP = 1e-5_dp    ! N m
        type(attitude_problem_t) :: trial
        real(dp), allocatable :: partials(:, :), torque(:, :), residuals(:)
        real(dp) :: normal(N, N), covariance(N, N), rhs(N), correction(N), condition
        real(dp) :: variance
        integer :: m, axis

        factor = 1
        sigma = 0
        misfit = 0
        call prepare_attitude(knowledge, problem%data, .true., trial)
        trial%quaternion = problem%quaternion
        trial%angular_velocity = problem%angular_velocity
        m = trial%observations
        allocate (partials(N, m), residuals(m))
        call trial%linearise_attitude(partials, residuals)
        torque = trial%fit%torque
        do axis = 1, 3
            trial%fit%torque(axis, :) = torque(axis, :) + TORQUE_STEP
            partials(6 + axis, :) = response()/TORQUE_STEP
            trial%fit%torque = torque
        end do
        trial%fit%torque = (1 + STEP)*torque
        partials(N, :) = response()/STEP
        call weight_angles(knowledge, problem%data, partials, residuals)
        call normal_equations(partials, residuals, normal, rhs)
        call solve_normal_equations(normal, rhs, correction, covariance, condition, error)
        if (allocated(error)) return
        factor = 1 + correction(N)
        associate (left => residuals - matmul(correction, partials), &
                   g => problem%data%attitude_source%fraction, &
                   shared => max(1.0_dp, knowledge%star_camera_interval/knowledge%accelerometer_interval))
            variance = sum(left**2)/max(1, m - N)*size(g)/sum((1 - g)**2 + g**2)
            if (noise_is_known(knowledge)) then
                misfit = sqrt(variance)
                variance = max(1.0_dp, variance)
            end if
            sigma = sqrt(covariance(N, N)*shared*variance)
        end associate

    contains

        !> The change of the computed angles under the torque of the trial.
        function response() result(change)
            real(dp) :: change(m)

            real(dp) :: unused(N, m)

            call trial%linearise_attitude(unused, change)
            change = residuals - change
        end function response
    end subroutine estimate_torque_factor

    pure logical function noise_is_known(knowledge)
        type(operator_knowledge_t), intent(in) :: knowledge

        noise_is_known = all(knowledge%star_camera_sigma > 0)
    end function noise_is_known

    !> Turns angles about the body's axes into those about the camera's axes, in units of their noise
    !> (if it is known).
    subroutine weight_angles(knowledge, data, partials, residuals)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        real(dp), intent(inout) :: partials(:, :)   !! Parameters x (3 times pseudo-observations)
        real(dp), intent(inout) :: residuals(:)

        real(dp) :: whiten(3, 3, HEADS)
        integer :: i, head

        if (.not. noise_is_known(knowledge)) return
        do head = 1, HEADS
            whiten(:, :, head) = rotation_matrix(knowledge%mounting(:, head))/ &
                                 spread(knowledge%star_camera_sigma, 2, 3)
        end do
        do i = 1, size(data%attitude_epoch)
            head = data%stars%head(data%attitude_source(i)%first)
            associate (angles => residuals(3*i - 2:3*i), columns => partials(:, 3*i - 2:3*i))
                angles = matmul(whiten(:, :, head), angles)
                columns = matmul(columns, transpose(whiten(:, :, head)))
            end associate
        end do
    end subroutine weight_angles
end module gracecg_estimation_fit_checks
