!> Whether the observations fit the manoeuvre: faults that leave a number with a small sigma.
module gracecg_estimation_fit_checks
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: string_t, append
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_observations_parameters, only: parameter_names, ATTITUDE_ANGLES, RATE, TORQUE, ROD_GAIN
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, &
        prepare_model, integrate_trajectory, star_angles
    use gracecg_estimation_fit_record, only: fit_record_t
    implicit none
    private
    public :: refuse_stuck_axis, check_accelerations, check_torque
    public :: DOUBTFUL, SIGNIFICANT, MISFITTING, MUCH_NOISE
    public :: judge_noise, find_excess

    !> A factor farther from 1 is warned of, farther still refused, if it is significant
    real(dp), parameter :: DOUBTFUL = 0.05_dp, WRONG = 0.5_dp
    real(dp), parameter :: SIGNIFICANT = 4      !! In standard deviations
    real(dp), parameter :: OUTLYING = 10        !! Of a residual, in RMS of all
    real(dp), parameter :: MUCH_NOISE = 20
    !! Of the residuals' RMS, in standard deviations of the accelerometer's noise: air drag that is not
    !! a straight line makes up to 5 in the cases of CSR-TM-00-01
    real(dp), parameter :: MISFITTING = 1.6_dp
    !! RMS of the star camera's residuals, in standard deviations of its noise: 0.97 to 1.02 in the cases of
    !! CSR-TM-00-01, 1.9 if the rods have twice the frequency that the setup says

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

        real(dp) :: rms
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
            call judge_noise(axis, rms, knowledge%accelerometer_noise(axis), data%interval, warnings, error)
            if (allocated(error)) return
        end do
    end subroutine check_accelerations

    !> Warns of residuals that are much larger than the noise, if that is known.
    subroutine judge_noise(axis, rms, spectrum, interval, warnings, error)
        integer, intent(in) :: axis    !! 1, 2, 3
        real(dp), intent(in) :: rms             !! Of the axis's residuals, m/s^2
        type(noise_spectrum_t), intent(in) :: spectrum  !! Of the axis, m^2 s^-4/Hz
        real(dp), intent(in) :: interval        !! Of the samples, s
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: times

        call find_excess(rms, spectrum, interval, times, error)
        if (allocated(error) .or. times <= MUCH_NOISE) return
        call append(warnings, 'accelerometer: the residuals of axis '//AXES(axis)//' have an RMS of '// &
                    number_text(rms)//' m/s^2, '//number_text(times)//' times the noise '// &
                    'of the setup: check the unit of the samples; the offset may be wrong')
    end subroutine judge_noise

    !> How many times what a spectrum lets expect residuals are; 0 where it says nothing. Fails as `coloured_noise` does.
    subroutine find_excess(rms, spectrum, interval, times, error)
        real(dp), intent(in) :: rms             !! m/s^2
        type(noise_spectrum_t), intent(in) :: spectrum  !! m^2 s^-4/Hz
        real(dp), intent(in) :: interval        !! Of the samples, s
        real(dp), intent(out) :: times          !! So many
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp) :: deviation(1)

        times = 0
        noise = coloured_noise(spectrum, interval, error)
        if (allocated(error)) return
        deviation = sqrt(noise%autocovariance([0]))
        if (deviation(1) > 0) times = rms/deviation(1)
    end subroutine find_excess

    !> Compares the magnetic torque m x B of the setup and the magnetometer with the turn that the star
    !> camera saw: rods that did not fire, a wrong sign, a wrong field. Fails when more than half of
    !> the torque is missing or too much; the offset would be off by as much. Warns of less, of a setup
    !> whose rods stay off, and of attitudes that no factor makes fit.
    subroutine check_torque(knowledge, data, star_sigma, quaternion, angular_velocity, warnings, error, record, kept)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        real(dp), intent(in) :: star_sigma(3)       !! Of the star camera about its axes, rad; 0: not known
        real(dp), intent(in) :: quaternion(4), angular_velocity(3)
        !! At the epoch, after the fit: inertial to body; rad/s
        type(string_t), allocatable, intent(inout) :: warnings(:)
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! What was found is put there
        logical, intent(in), optional :: kept(:)    !! Star-camera samples; all when absent

        real(dp) :: factor, sigma       ! of the torque that fits best, and its standard deviation
        real(dp) :: misfit              ! RMS of the attitude's residuals in units of their noise
        logical :: counted(size(data%stars%time))
        character(8) :: means
        character(:), allocatable :: found, doubt

        associate (direct => knowledge%rods%direct)
            if (.not. any(abs(data%torque) > 0)) then
                call append(warnings, 'the '//trim(merge('torquers   ', 'torque rods', direct))// &
                            ' are off all the time: the offset is hardly observable')
                return
            end if
            counted = .true.
            if (present(kept)) counted = kept
            call estimate_torque_factor(knowledge, data, counted, star_sigma, quaternion, angular_velocity, factor, &
                                        sigma, misfit, error)
            if (allocated(error)) return
            if (present(record)) then
                record%torque_checked = .true.
                record%torque_factor = factor
                record%torque_sigma = sigma
                record%attitude_misfit = misfit
            end if
            means = merge('torquers', 'rods    ', direct)
            doubt = ''
            if (misfit > MISFITTING) then
                doubt = 'the attitudes of the star camera are off the fit, by '//number_text(misfit)// &
                        ' times their noise: faulty samples, or '//trim(means)//' that fired otherwise than the setup says'
                call append(warnings, doubt)
                doubt = '; '//doubt
            end if
            if (abs(factor - 1) <= max(DOUBTFUL, SIGNIFICANT*sigma)) return
            found = 'the satellite turned as if the torque of the '//trim(means)//' were '// &
                number_text(factor)//' (sigma '//number_text(sigma)//') times that of setup and '// &
                trim(merge('command       ', 'magnetic field', direct))
            if (abs(factor - 1) > WRONG) then
                call fail(error, found//': did the '//trim(means)//' fire as the setup says?'//doubt)
            else
                call append(warnings, found//'; the offset may be off by as much')
            end if
        end associate
    end subroutine check_torque

    !> The factor of the magnetic torque that would fit the star camera's samples best, estimated together with
    !> attitude and angular velocity at the epoch and a constant torque about each axis (what the physical model
    !> leaves out), by one linear step from the fit. The angles are weighted with the star camera's noise
    !> about its axes (the boresight is worse by far). The standard deviation comes from the residuals, but is
    !> at least that of the star camera's noise.
    subroutine estimate_torque_factor(knowledge, data, kept, star_sigma, quaternion, angular_velocity, factor, &
                                      sigma, misfit, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: kept(:)                      !! Star-camera samples that count
        real(dp), intent(in) :: star_sigma(3)               !! About camera x, y, boresight, rad; 0: not known
        real(dp), intent(in) :: quaternion(4), angular_velocity(3)
        !! At the epoch, after the fit: inertial to body; rad/s
        real(dp), intent(out) :: factor, sigma              !! 1: as it should be; standard deviation
        real(dp), intent(out) :: misfit
        !! RMS of the residuals in standard deviations of the noise; 0 if that is unknown
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: FITTED(10) = [ATTITUDE_ANGLES, RATE, TORQUE, ROD_GAIN], N = size(FITTED)
        type(fitting_data_t) :: copy                        ! so that warnings are not said twice
        type(physical_model_t) :: model
        type(model_state_t) :: state
        type(model_trajectory_t) :: trajectory
        real(dp) :: partials(N, 3*size(kept)), residuals(3*size(kept)), angles(3), by(N, 3), unit(3)
        real(dp) :: normal(N, N), covariance(N, N), rhs(N), correction(N), condition, variance
        logical :: noise_known
        integer :: i, axis

        factor = 1
        sigma = 0
        misfit = 0
        noise_known = all(star_sigma > 0)
        unit = merge(star_sigma, 1.0_dp, noise_known)
        copy = data
        call prepare_model(knowledge, copy, FITTED, model)
        state%quaternion = quaternion
        state%value(RATE) = angular_velocity
        call integrate_trajectory(model, state, trajectory)
        partials = 0
        residuals = 0
        associate (stars => data%stars)
            do i = 1, size(kept)
                if (.not. kept(i)) cycle
                call star_angles(model, state, trajectory, stars%time(i), stars%head(i), stars%quaternion(:, i), angles, by)
                do axis = 1, 3
                    residuals(3*i - 3 + axis) = angles(axis)/unit(axis)
                    partials(:, 3*i - 3 + axis) = by(:, axis)/unit(axis)
                end do
            end do
        end associate
        call normal_equations(partials, residuals, normal, rhs)
        call solve_normal_equations(normal, rhs, correction, covariance, condition, error, parameter_names(FITTED))
        if (allocated(error)) return
        factor = 1 + correction(N)
        variance = sum((residuals - matmul(correction, partials))**2)/max(1, 3*count(kept) - N)
        if (noise_known) then
            misfit = sqrt(variance)
            variance = max(1.0_dp, variance)
        end if
        sigma = sqrt(covariance(N, N)*variance)
    end subroutine estimate_torque_factor
end module gracecg_estimation_fit_checks
