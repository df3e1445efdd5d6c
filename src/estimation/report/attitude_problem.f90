!> Attitude and angular velocity at the epoch from the star camera: the first part of ASSEST, and the
!> attitude part of ASCFEST and ASCREST (CSR-TM-00-01 section 4.6).
!>
!> Two states are in use. Full: [q(t0), omega(t0)], seven parameters of which six are independent,
!> since a quaternion has unit length. Reduced: [zeta(t0), d omega(t0)], six: small angles that turn
!> the nominal attitude into the true one.
module gracecg_estimation_attitude_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_vectors, only: identity
    use gracecg_base_quaternion, only: normalised, rotation_matrix, quaternion_of_matrix
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_attitude_fit, only: attitude_fit_t, fitted_rotation_t, fitted_attitude_t, &
        new_attitude_fit, kinematic_partials
    use gracecg_estimation_batch_problem, only: batch_problem_t, batch_solution_t
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    use gracecg_estimation_solution, only: solution_t
    implicit none
    private
    public :: attitude_problem_t, prepare_attitude, store_rotation, small_angles, small_rotation

    real(dp), parameter :: TYPICAL_RATE = 1e-3_dp   !! Scale of the angular velocity, rad/s

    !> Attitude and angular velocity at the epoch from the star camera: the first part of ASSEST.
    type, extends(batch_problem_t) :: attitude_problem_t
        logical :: reduced = .false.            !! Reduced instead of full state
        type(attitude_fit_t) :: fit             !! The dynamics that is fitted
        type(fitting_data_t) :: data            !! The observations, preprocessed
        real(dp) :: quaternion(4) = 0           !! q*(t0)
        real(dp) :: angular_velocity(3) = 0     !! omega*(t0), rad/s
        real(dp) :: attitude_weight = 1         !! Of every component of an attitude observation
        type(fitted_rotation_t) :: rotation     !! Along the last nominal trajectory
    contains
        procedure :: linearise => linearise_alone
        procedure :: correct => correct_attitude    !! Puts a correction on attitude and rate
        procedure :: attitude_components    !! Scalars of one attitude observation: 4 or 3
        procedure :: attitude_parameters    !! Attitude parameters of the state: 4 or 3
        procedure :: linearise_attitude     !! Trajectory, partials and residuals of the attitude
        procedure :: quaternion_gain        !! The estimate's response to the quaternions
        procedure :: small_angle_map        !! Errors of the attitude's parameters as small angles
        procedure :: describe_residuals => residuals_of_attitude
        procedure :: describe_state => state_of_attitude
    end type attitude_problem_t

contains

    !> Sets up the problem from preprocessed observations.
    subroutine prepare_attitude(knowledge, data, reduced, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: reduced  !! Small angles in place of the quaternion
        class(attitude_problem_t), intent(inout) :: problem

        problem%reduced = reduced
        problem%data = data
        problem%fit = new_attitude_fit(knowledge%inertia, data%interval, data%torque)
        problem%quaternion = data%guess_quaternion
        problem%angular_velocity = data%guess_angular_velocity
        if (reduced) then
            problem%names = [character(12) :: 'zeta_x', 'zeta_y', 'zeta_z', 'omega_x', 'omega_y', 'omega_z']
        else
            problem%names = [character(12) :: 'q1', 'q2', 'q3', 'q4', 'omega_x', 'omega_y', 'omega_z']
        end if
        problem%scales = spread(1.0_dp, 1, problem%attitude_parameters())
        problem%scales(problem%attitude_components() + 1:) = TYPICAL_RATE
        problem%observations = problem%attitude_components()*size(data%attitude_epoch)
    end subroutine prepare_attitude

    !> Puts attitude and angular velocity of a fit into a solution.
    subroutine store_rotation(problem, batch, solution)
        class(attitude_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        type(solution_t), intent(inout) :: solution

        solution%quaternion = problem%quaternion
        solution%angular_velocity = problem%angular_velocity
        solution%iterations = batch%iterations
        solution%converged = batch%converged
        if (allocated(batch%history)) solution%history = batch%history
    end subroutine store_rotation

    !> Scalars in one attitude observation: 4 of the quaternion, or 3 angles.
    pure integer function attitude_components(self) result(n)
        class(attitude_problem_t), intent(in) :: self

        n = merge(3, 4, self%reduced)
    end function attitude_components

    pure integer function attitude_parameters(self) result(n)
        class(attitude_problem_t), intent(in) :: self

        n = self%attitude_components() + 3
    end function attitude_parameters

    subroutine linearise_alone(self, partials, residuals, weights, error)
        class(attitude_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error

        call self%linearise_attitude(partials, residuals)
        weights = self%attitude_weight
    end subroutine linearise_alone

    !> Integrates the nominal trajectory; partials and residuals of all attitude observations q_obs = q,
    !> (4-19), (4-52), (4-60), (4-86), (4-95). Partials: (4-25) times Phi (4-56) or (4-73). Residuals of the
    !> reduced state: the angles of (4-69), (4-71), (4-72), (4-100).
    subroutine linearise_attitude(self, partials, residuals)
        class(attitude_problem_t), intent(inout) :: self
        real(dp), intent(out) :: partials(:, :)     !! At least the attitude parameters x observations
        real(dp), intent(out) :: residuals(:)       !! Observed minus computed; quaternion components, or rad

        type(fitted_attitude_t) :: attitude
        real(dp) :: full(4, 7), small(3, 6)
        integer :: i, k, first, n

        n = self%attitude_components()
        call self%fit%fit_attitude(self%quaternion, self%angular_velocity, attitude, self%rotation)
        do i = 1, size(self%data%attitude_epoch)
            k = self%data%attitude_epoch(i)
            first = n*(i - 1)
            associate (residual => residuals(first + 1:first + n), observed => self%data%quaternion(:, i))
                if (self%reduced) then      ! H~ = [I 0], (4-57), (4-74)
                    small = attitude%angle_transition(k)
                    partials(:6, first + 1:first + 3) = transpose(small)
                    residual = small_angles(matmul(rotation_matrix(observed), &
                                                   transpose(rotation_matrix(normalised(attitude%q(:, k))))))
                else
                    full = attitude%quaternion_transition(k)
                    partials(:7, first + 1:first + 4) = transpose(full)
                    residual = observed - attitude%q(:, k)
                end if
            end associate
        end do
    end subroutine linearise_attitude

    !> X* + x. The nominal quaternion is normalised before the next iteration; in the reduced state the
    !> quaternion of C(zeta) R(q*), (4-61), (4-79), replaces q* ((4-75) and (4-103) print an addition). In the
    !> full state the normalisation undoes a part of the correction, and what is left is returned: where
    !> the torque is not known well, the least-squares quaternion stays shorter than 1, and every
    !> correction asks for that anew.
    subroutine correct_attitude(self, correction)
        class(attitude_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)    !! At least the attitude parameters

        real(dp) :: before(4)
        integer :: n

        n = self%attitude_components()
        if (self%reduced) then
            self%quaternion = quaternion_of_matrix(matmul(small_rotation(correction(1:3)), &
                                                          rotation_matrix(self%quaternion)))
        else
            before = self%quaternion
            self%quaternion = normalised(before + correction(1:4))
            correction(1:4) = self%quaternion - before
        end if
        self%angular_velocity = self%angular_velocity + correction(n + 1:n + 3)
    end subroutine correct_attitude

    !> A gain on the attitude observations as a gain on quaternions: parameters x 4 x observations.
    function quaternion_gain(self, gain) result(on_quaternions)
        class(attitude_problem_t), intent(in) :: self
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
        class(attitude_problem_t), intent(in) :: self
        real(dp), allocatable :: map(:, :)          !! 3 x attitude components

        if (self%reduced) then
            map = identity(3)
        else
            map = 4*transpose(kinematic_partials(self%quaternion))
        end if
    end function small_angle_map

    !> RMS of the attitude's residuals: of the quaternion's components, or of small angles.
    subroutine residuals_of_attitude(self, residuals, note)
        class(attitude_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)        !! Those of the attitude first
        type(iteration_t), intent(inout) :: note

        integer :: n, last, i

        n = self%attitude_components()
        last = n*size(self%data%attitude_epoch)
        note%residual_names = [character(12) :: 'q1', 'q2', 'q3', 'q4']
        if (self%reduced) note%residual_names = [character(12) :: 'zeta_x', 'zeta_y', 'zeta_z']
        note%residual_rms = [(rms_of(residuals(i:last:n)), i=1, n)]
        note%residual_unit = merge('rad', '1  ', self%reduced)
    end subroutine residuals_of_attitude

    subroutine state_of_attitude(self, note)
        class(attitude_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        note%state_names = [character(12) :: 'q1', 'q2', 'q3', 'q4', 'omega_x', 'omega_y', 'omega_z']
        note%state = [self%quaternion, self%angular_velocity]
    end subroutine state_of_attitude

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
end module gracecg_estimation_attitude_problem
