!> From the truth of a case to what its operator is told: the truth with the operator's errors.
!>
!> What an operator measures on the ground (mass properties, rods, mounting, noise) is believed as it is,
!> but for the errors. The instruments' true scale factors and biases are what a calibration in flight
!> suffers from: the operator takes them for 1 and 0, but for the errors.
module gracecg_simulation_operator_view
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_matrix
    use gracecg_base_vectors, only: cross, unit
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_simulation_case, only: case_t, earth_orientation_name, sidereal_angle_at_epoch
    use gracecg_simulation_operator_errors
    implicit none
    private
    public :: operator_knowledge, believed_position

contains

    !> What an operator is told of a case: nothing of sigmas that are still to be drawn.
    function operator_knowledge(case, operator) result(knowledge)
        type(case_t), intent(in) :: case
        type(operator_t), intent(in) :: operator    !! The case's own, or that of a run
        type(operator_knowledge_t) :: knowledge

        integer :: head

        knowledge%name = case%name
        knowledge%epoch = case%epoch
        knowledge%duration = case%duration
        knowledge%limits = case%limits
        knowledge%camera = operator%head
        knowledge%a_priori = operator%a_priori
        knowledge%sidereal_angle = sidereal_angle_at_epoch(case)
        knowledge%earth_orientation = earth_orientation_name(case)
        knowledge%earth_parameters = case%earth_parameters
        knowledge%field_model = case%field_model
        if (case%field_model == 'file') knowledge%field_model = 'igrf14'
        if (operator%field_model /= AS_TRUTH) knowledge%field_model = operator%field_model
        associate (satellite => case%satellite)
            knowledge%mass = satellite%mass*(1 + operator%value(1, MASS))
            knowledge%inertia = believed_inertia(satellite%inertia, operator)
            knowledge%rods = satellite%rods
            knowledge%rods%torque_file = ''         ! a setup does not depend on other files
            knowledge%rods%gain = satellite%rods%gain*(1 + operator%value(1, COMMON_ROD_GAIN))* &
                                  (1 + errors_of(operator, ROD_GAIN))
            knowledge%rods%misalignment = satellite%rods%misalignment + errors_of(operator, ROD_DIRECTION)
            knowledge%rods%delay = satellite%rods%delay + errors_of(operator, ROD_DELAY)
            knowledge%accelerometer_interval = satellite%accelerometer%sampling_interval
            knowledge%star_camera_interval = satellite%star_camera%sampling_interval
            knowledge%magnetometer_interval = satellite%magnetometer%sampling_interval
            if (satellite%accelerometer%limited) knowledge%accelerometer_range = satellite%accelerometer%range
            if (satellite%magnetometer%limited) knowledge%magnetometer_range = satellite%magnetometer%range
            knowledge%accelerometer_noise = satellite%accelerometer%noise
            knowledge%line = satellite%line
            knowledge%accelerometer_noise%level = satellite%accelerometer%noise%level* &
                                                  errors_of(operator, ACCELEROMETER_NOISE)/satellite%line%number
            do head = 1, HEADS
                knowledge%mounting(:, head) = turned(satellite%star_camera%mounting(head), &
                                                     operator%value(3*head - 2:3*head, MOUNTING))
            end do
        end associate
        knowledge%accelerometer_scale = 1 + errors_of(operator, ACCELEROMETER_SCALE)
        knowledge%accelerometer_delay = operator%value(1, ACCELEROMETER_DELAY)
        knowledge%magnetometer_bias = errors_of(operator, MAGNETOMETER_BIAS)
        knowledge%torque_change = errors_of(operator, TORQUE_CHANGE)
    end function operator_knowledge

    !> The inertia tensor that is believed in: principal moments and axes with their errors, then the elements
    !> with theirs.
    function believed_inertia(inertia_tensor, operator) result(believed)
        real(dp), intent(in) :: inertia_tensor(3, 3)    !! J_p, kg m^2
        type(operator_t), intent(in) :: operator
        real(dp) :: believed(3, 3)

        real(dp) :: moments(3), axes(3, 3), element(6), smallest
        type(error_t), allocatable :: never     ! a symmetric matrix of three rows always has its axes
        integer :: i

        believed = inertia_tensor
        associate (relative => errors_of(operator, PRINCIPAL_MOMENTS), turn => errors_of(operator, PRINCIPAL_AXES))
            if (any(abs([relative, turn]) > 0)) then
                call symmetric_eigen(inertia_tensor, moments, axes, never)
                ! rotation_matrix turns the frame, its transpose the axes
                axes = matmul(transpose(rotation_matrix(turned([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], turn))), axes)
                believed = matmul(axes*spread(moments*(1 + relative), 1, 3), transpose(axes))
                believed = (believed + transpose(believed))/2
            end if
        end associate
        element = errors_of(operator, INERTIA)
        if (.not. any(abs(element) > 0)) return
        smallest = minval([(inertia_tensor(i, i), i=1, 3)])
        believed = believed + smallest*reshape([element(1), element(4), element(6), &
                                                element(4), element(2), element(5), &
                                                element(6), element(5), element(3)], [3, 3])
    end function believed_inertia

    !> A rotation followed by a turn about the axes that it leads to.
    pure function turned(q, turn) result(after)
        real(dp), intent(in) :: q(4)        !! Scalar last
        real(dp), intent(in) :: turn(3)     !! Rotation vector, rad
        real(dp) :: after(4)

        after = q
        if (norm2(turn) > 0) after = quaternion_product(quaternion_from_axis_angle(unit(turn), norm2(turn)), q)
    end function turned

    !> The position that the operator's orbit has for a time, with the errors of position and velocity in the
    !> radial, along-track and cross-track axes of the epoch, and tags that are late: the position is that of an
    !> earlier time, to the third order.
    pure function believed_position(operator, epoch_state, state, time) result(believed)
        type(operator_t), intent(in) :: operator
        real(dp), intent(in) :: epoch_state(6), state(6)    !! True position and velocity, at 0 and at `time`, inertial
        real(dp), intent(in) :: time                        !! s
        real(dp) :: believed(3)                             !! m

        real(dp) :: axes(3, 3)

        believed = state(:3)
        if (.not. any(abs(operator%value(:3, [ORBIT_POSITION, ORBIT_VELOCITY, ORBIT_TIME])) > 0)) return
        axes(:, 1) = unit(epoch_state(:3))
        axes(:, 3) = unit(cross(epoch_state(:3), epoch_state(4:)))
        axes(:, 2) = cross(axes(:, 3), axes(:, 1))
        associate (late => operator%value(1, ORBIT_TIME))
            believed = believed - late*state(4:) - late**2/2*EARTH_GM/norm2(state(:3))**3*state(:3)
        end associate
        believed = believed + matmul(axes, errors_of(operator, ORBIT_POSITION) + &
                                     time*errors_of(operator, ORBIT_VELOCITY))
    end function believed_position
end module gracecg_simulation_operator_view
