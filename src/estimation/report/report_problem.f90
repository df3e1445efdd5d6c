!> The least-squares problems of the report's estimators, CSR-TM-00-01 section 4.6, for the batch processor of Figure 4.1.
!>
!> Attitude and angular velocity at the epoch from the star camera, and the CG offset from the accelerometer: ASSEST fits
!> one after the other, ASCFEST and ASCREST both together. Two states of the attitude are in use. Full: [q(t0),
!> omega(t0)], seven parameters of which six are independent, since a quaternion has unit length. Reduced: [zeta(t0),
!> d omega(t0)], six: small angles that turn the nominal attitude into the true one. That of the accelerometer is
!> [d, alpha, beta], in which its observations are linear.
module gracecg_estimation_report_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_vectors, only: identity
    use gracecg_base_quaternion, only: normalised, rotation_matrix, quaternion_of_matrix
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_attitude_fit, only: attitude_fit_t, fitted_rotation_t, new_attitude_fit, kinematic_partials
    use gracecg_estimation_batch_problem, only: batch_problem_t
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    use gracecg_estimation_offset_model, only: offset_matrix, offset_rate_partials
    implicit none
    private
    public :: report_problem_t, prepare_problem, small_angles, small_rotation, OFFSET_PARAMETERS

    !> Number of the parameters of the accelerometer's state [d, alpha, beta]
    integer, parameter :: OFFSET_PARAMETERS = 9
    character(12), parameter :: OFFSET_NAMES(OFFSET_PARAMETERS) = [character(12) :: &
        'd_x', 'd_y', 'd_z', 'alpha_x', 'alpha_y', 'alpha_z', 'beta_x', 'beta_y', 'beta_z']
    character(12), parameter :: QUATERNION_NAMES(4) = [character(12) :: 'q1', 'q2', 'q3', 'q4'], &
                                ANGLE_NAMES(3) = [character(12) :: 'zeta_x', 'zeta_y', 'zeta_z'], &
                                RATE_NAMES(3) = [character(12) :: 'omega_x', 'omega_y', 'omega_z']
    !> Typical sizes: of the angular velocity, rad/s, the offset, m, and accelerations, m/s^2
    real(dp), parameter :: TYPICAL_RATE = 1e-3_dp, TYPICAL_OFFSET = 1e-3_dp, TYPICAL_ACCELERATION = 1e-6_dp

    !> What is fitted. The parameters of the attitude, and its observations, come before those of the accelerometer.
    type, extends(batch_problem_t) :: report_problem_t
        logical :: reduced = .false.            !! Small angles in place of the quaternion
        type(attitude_fit_t) :: fit             !! The dynamics that is fitted
        type(fitting_data_t) :: data            !! The observations, preprocessed
        real(dp) :: quaternion(4) = 0           !! q*(t0)
        real(dp) :: angular_velocity(3) = 0     !! omega*(t0), rad/s
        real(dp) :: offset_state(OFFSET_PARAMETERS) = 0     !! d (m), alpha (m/s^3), beta (m/s^2)
        real(dp) :: attitude_weight = 1         !! Of every component of an attitude observation
        real(dp) :: accelerometer_weight(3) = 1 !! Of its axes
        type(fitted_rotation_t) :: rotation     !! Along the last nominal trajectory
        integer :: components = 4               !! Scalars of an attitude: 4 of the quaternion, or 3 angles
        integer :: attitude_parameters = 0      !! That are fitted: components and angular velocity, or none
        integer :: attitude_observations = 0    !! Scalars of them
        logical :: fits_offset = .false.        !! The state of the accelerometer is fitted
    contains
        procedure :: choose                     !! What is fitted
        procedure :: linearise => linearise_report
        procedure :: correct => correct_report
        procedure :: quaternion_gain            !! The estimate's response to the quaternions
        procedure :: small_angle_map            !! Errors of the attitude's parameters as small angles
        procedure :: describe_residuals
        procedure :: describe_state
    end type report_problem_t

contains

    !> Sets up the problem from preprocessed observations, at the first guess.
    subroutine prepare_problem(knowledge, options, data, reduced, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: reduced  !! Small angles in place of the quaternion
        type(report_problem_t), intent(out) :: problem

        problem%reduced = reduced
        problem%components = merge(3, 4, reduced)
        problem%data = data
        problem%fit = new_attitude_fit(knowledge%inertia, data%interval, data%torque)
        problem%quaternion = data%guess_quaternion
        problem%angular_velocity = data%guess_angular_velocity
        problem%offset_state(:3) = options%guess_offset
        problem%attitude_weight = options%star_camera_weight
        problem%accelerometer_weight = options%accelerometer_weight
    end subroutine prepare_problem

    !> What is fitted: attitude and angular velocity, the state of the accelerometer, or both.
    subroutine choose(self, attitude, offset)
        class(report_problem_t), intent(inout) :: self
        logical, intent(in) :: attitude, offset     !! What the state has

        self%names = OFFSET_NAMES(:0)
        self%scales = [real(dp) ::]
        self%attitude_parameters = 0
        self%attitude_observations = 0
        self%fits_offset = offset
        self%linear = .not. attitude
        if (attitude) then
            self%attitude_parameters = self%components + 3
            self%attitude_observations = self%components*size(self%data%attitude_epoch)
            if (self%reduced) self%names = [ANGLE_NAMES, RATE_NAMES]
            if (.not. self%reduced) self%names = [QUATERNION_NAMES, RATE_NAMES]
            self%scales = [spread(1.0_dp, 1, self%components), spread(TYPICAL_RATE, 1, 3)]
        end if
        self%observations = self%attitude_observations
        if (.not. offset) return
        self%observations = self%observations + 3*size(self%data%accelerometer_epoch)
        self%names = [self%names, OFFSET_NAMES]
        self%scales = [self%scales, spread(TYPICAL_OFFSET, 1, 3), &
                       spread(TYPICAL_ACCELERATION/(self%data%steps*self%data%interval), 1, 3), &
                       spread(TYPICAL_ACCELERATION, 1, 3)]
    end subroutine choose

    !> H = [0, dA/d omega Phi_22, A~, t I, I; Phi_11, Phi_12, 0, 0, 0], eqs. (4-90), (4-91), (4-101), (4-102),
    !> of the observations (4-85), (4-86) or (4-94), (4-95), or a part of it; the zeros are (4-20), (4-26).
    subroutine linearise_report(self, partials, residuals, weights, error)
        class(report_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :) !! Parameters x observations
        real(dp), intent(out) :: residuals(:), weights(:)   !! Observed minus computed; weights
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        call self%fit%integrate(self%quaternion, self%angular_velocity, self%rotation)
        partials = 0
        associate (last => self%attitude_observations)
            if (last > 0) call linearise_attitude(self, partials(:, :last), residuals(:last))
            weights(:last) = self%attitude_weight
            if (.not. self%fits_offset) return
            call linearise_accelerations(self, partials(:, last + 1:), residuals(last + 1:))
            do axis = 1, 3
                weights(last + axis::3) = self%accelerometer_weight(axis)
            end do
        end associate
    end subroutine linearise_report

    !> Partials and residuals of all attitude observations q_obs = q,
    !> (4-19), (4-52), (4-60), (4-86), (4-95). Partials: (4-25) times Phi (4-56) or (4-73). Residuals of the
    !> reduced state: the angles of (4-69), (4-71), (4-72), (4-100).
    subroutine linearise_attitude(self, partials, residuals)
        class(report_problem_t), intent(in) :: self
        real(dp), contiguous, intent(inout) :: partials(:, :)
        real(dp), intent(out) :: residuals(:)       !! Observed minus computed; quaternion components, or rad

        real(dp) :: full(4, 7), small(3, 6)         ! faster than a result without a place
        integer :: i, k, first

        do i = 1, size(self%data%attitude_epoch)
            k = self%data%attitude_epoch(i)
            first = self%components*(i - 1)
            associate (residual => residuals(first + 1:first + self%components), observed => self%data%quaternion(:, i))
                if (self%reduced) then      ! H~ = [I 0], (4-57), (4-74)
                    small = self%rotation%angle_transition(k)
                    partials(:6, first + 1:first + 3) = transpose(small)
                    residual = small_angles(matmul(rotation_matrix(observed), &
                                                   transpose(rotation_matrix(normalised(self%rotation%q(:, k))))))
                else
                    full = self%rotation%quaternion_transition(k)
                    partials(:7, first + 1:first + 4) = transpose(full)
                    residual = observed - self%rotation%q(:, k)
                end if
            end associate
        end do
    end subroutine linearise_attitude

    !> Partials [A~, t I, I] of (4-22)-(4-24), (4-82), behind those by the angular velocity, and residuals of the
    !> accelerometer, (4-18), (4-81).
    subroutine linearise_accelerations(self, partials, residuals)
        class(report_problem_t), intent(in) :: self
        real(dp), contiguous, intent(inout) :: partials(:, :)   !! Parameters x (3 times samples)
        real(dp), intent(out) :: residuals(:)               !! m/s^2

        real(dp) :: t, a(3, 3), by_rate(3, 3)
        integer :: i, k, row, axis

        associate (data => self%data, rotation => self%rotation, p => self%attitude_parameters, state => self%offset_state)
            do i = 1, size(data%accelerometer_epoch)
                k = data%accelerometer_epoch(i)
                t = k*data%interval
                row = 3*(i - 1)
                a = offset_matrix(rotation%omega(:, k), rotation%omega_dot(:, k))
                partials(p + 1:p + 3, row + 1:row + 3) = transpose(a)
                do axis = 1, 3
                    partials(p + 3 + axis, row + axis) = t
                    partials(p + 6 + axis, row + axis) = 1
                end do
                residuals(row + 1:row + 3) = data%acceleration(:, i) - matmul(a, state(1:3)) - state(4:6)*t - state(7:9)
                if (p == 0) cycle
                by_rate = self%fit%body%rate_partials(rotation%omega(:, k))
                by_rate = offset_rate_partials(rotation%omega(:, k), state(1:3), by_rate)
                by_rate = matmul(by_rate, rotation%phi_22(:, :, k))
                partials(p - 2:p, row + 1:row + 3) = transpose(by_rate)
            end do
        end associate
    end subroutine linearise_accelerations

    !> X* + x, (4-103). The nominal quaternion is normalised before the next iteration; in the reduced state the
    !> quaternion of C(zeta) R(q*), (4-61), (4-79), replaces q* ((4-75) and (4-103) print an addition). In the
    !> full state the normalisation undoes a part of the correction, and what is left is returned: where
    !> the torque is not known well, the least-squares quaternion stays shorter than 1, and every
    !> correction asks for that anew.
    subroutine correct_report(self, correction)
        class(report_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        real(dp) :: before(4)

        associate (p => self%attitude_parameters)
            if (p > 0) then
                if (self%reduced) then
                    self%quaternion = quaternion_of_matrix(matmul(small_rotation(correction(1:3)), &
                                                                  rotation_matrix(self%quaternion)))
                else
                    before = self%quaternion
                    self%quaternion = normalised(before + correction(1:4))
                    correction(1:4) = self%quaternion - before
                end if
                self%angular_velocity = self%angular_velocity + correction(p - 2:p)
            end if
            if (self%fits_offset) self%offset_state = self%offset_state + correction(p + 1:)
        end associate
    end subroutine correct_report

    !> A gain on the attitude observations as a gain on quaternions: parameters x 4 x observations.
    function quaternion_gain(self, gain) result(on_quaternions)
        class(report_problem_t), intent(in) :: self
        real(dp), intent(in) :: gain(:, :)          !! Parameters x (components times observations)
        real(dp), allocatable :: on_quaternions(:, :, :)

        integer :: i, m

        m = size(self%data%attitude_epoch)
        if (.not. self%reduced) then
            on_quaternions = reshape(gain, [size(gain, 1), 4, m])
            return
        end if
        allocate (on_quaternions(size(gain, 1), 4, m))
        do i = 1, m     ! d zeta = 4 Gamma^T dq, the inverse of dq = Gamma d zeta
            on_quaternions(:, :, i) = 4*matmul(gain(:, 3*i - 2:3*i), &
                                               transpose(kinematic_partials(self%data%quaternion(:, i))))
        end do
    end function quaternion_gain

    !> What takes an error of the attitude's parameters to small angles about the body axes: I, or of the
    !> quaternion 4 Gamma^T, without what changes its length.
    pure function small_angle_map(self) result(map)
        class(report_problem_t), intent(in) :: self
        real(dp), allocatable :: map(:, :)          !! 3 x attitude components

        if (self%reduced) then
            map = identity(3)
        else
            map = 4*transpose(kinematic_partials(self%quaternion))
        end if
    end function small_angle_map

    !> RMS of the residuals: of the quaternion's components or small angles, of the accelerometer's axes.
    subroutine describe_residuals(self, residuals, note)
        class(report_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)        !! Those of the attitude first
        type(iteration_t), intent(inout) :: note

        integer :: i

        note%residual_names = self%names(:0)
        note%residual_rms = [real(dp) ::]
        associate (last => self%attitude_observations, n => self%components)
            if (last > 0) then
                note%residual_names = self%names(:n)
                note%residual_rms = [(rms_of(residuals(i:last:n)), i=1, n)]
                note%residual_unit = merge('rad', '1  ', self%reduced)
            end if
            if (.not. self%fits_offset) return
            note%residual_names = [character(12) :: note%residual_names, 'acc_x', 'acc_y', 'acc_z']
            note%residual_rms = [note%residual_rms, (rms_of(residuals(last + i::3)), i=1, 3)]
            if (last > 0) note%residual_unit = trim(note%residual_unit)//', m/s^2'
            if (last == 0) note%residual_unit = 'm/s^2'
        end associate
    end subroutine describe_residuals

    subroutine describe_state(self, note)
        class(report_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        note%state_names = self%names(:0)
        note%state = [real(dp) ::]
        if (self%attitude_parameters > 0) then
            note%state_names = [QUATERNION_NAMES, RATE_NAMES]
            note%state = [self%quaternion, self%angular_velocity]
        end if
        if (.not. self%fits_offset) return
        note%state_names = [note%state_names, OFFSET_NAMES]
        note%state = [note%state, self%offset_state]
    end subroutine describe_state

    !> The angles of the sequence 3-2-1 of a rotation matrix, eqs. (4-70), (4-71).
    pure function small_angles(c) result(u)
        real(dp), intent(in) :: c(3, 3)             !! A rotation matrix near the identity
        real(dp) :: u(3)                            !! rad

        u = [atan2(c(2, 3), c(3, 3)), -asin(max(-1.0_dp, min(1.0_dp, c(1, 3)))), atan2(c(1, 2), c(1, 1))]
    end function small_angles

    !> The rotation matrix of angles in the sequence 3-2-1, eq. (4-62): the inverse of small_angles.
    pure function small_rotation(u) result(c)
        real(dp), intent(in) :: u(3)                !! rad
        real(dp) :: c(3, 3)

        associate (c1 => cos(u(1)), c2 => cos(u(2)), c3 => cos(u(3)), &
                   s1 => sin(u(1)), s2 => sin(u(2)), s3 => sin(u(3)))
            c(1, :) = [c2*c3, c2*s3, -s2]
            c(2, :) = [s1*s2*c3 - c1*s3, s1*s2*s3 + c1*c3, s1*c2]
            c(3, :) = [c1*s2*c3 + s1*s3, c1*s2*s3 - s1*c3, c1*c2]
        end associate
    end function small_rotation
end module gracecg_estimation_report_problem
