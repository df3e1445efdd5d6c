!> Accelerometers on a line, equally spaced, such as the three of ESA's Next Generation Gravity Mission: how their samples become
!> the mean, as of one accelerometer in their middle, and contrasts between them.
!>
!> At r from the middle one senses M (d + r) + a_ng, M = [d omega/dt x] + [omega x]^2 + G, CSR-TM-00-01 eq. (3-7). The contrasts
!> are sum_k c_jk a_k with orthonormal polynomials c_j of degree j over the places: of samples of equal noise their errors are
!> independent of each other and of the mean's, whose variance is that of one accelerometer by their number.
module gracecg_observations_accelerometer_line
    use gracecg_base_kinds, only: dp
    use gracecg_files_settings, only: settings_t
    implicit none
    private
    public :: accelerometer_line_t, describe_line

    integer, parameter :: MOST = 3                      !! Accelerometers
    real(dp), parameter :: CLOSEST = 1e-3_dp            !! m, from one to the next
    !> c_jk, (k, j), of two and of three
    real(dp), parameter :: OF_TWO(2, 1) = reshape([-1, 1], [2, 1])/sqrt(2.0_dp)
    real(dp), parameter :: OF_THREE(3, 2) = reshape([-1/sqrt(2.0_dp), 0.0_dp, 1/sqrt(2.0_dp), &
                                                     1/sqrt(6.0_dp), -2/sqrt(6.0_dp), 1/sqrt(6.0_dp)], [3, 2])

    !> How many there are, where, and how alike. d of an observation set is that of their middle.
    type :: accelerometer_line_t
        integer :: number = 1               !! Of accelerometers
        real(dp) :: spacing(3) = 0          !! From one to the next, body axes, m
        real(dp) :: scale_sigma(3) = 0.01_dp
        !! Standard deviation of what their scale factors differ by from their mean, x, y, z, relative
    contains
        procedure :: place                  !! Of each of them
        procedure :: direction              !! Of the line
        procedure :: reach                  !! rho: the norm of all their places
        procedure :: weights                !! Of the contrasts
        procedure :: combine                !! Their samples into means and contrasts
    end type accelerometer_line_t

contains

    !> Where the k-th accelerometer is, from the middle, body axes, m.
    pure function place(self, k)
        class(accelerometer_line_t), intent(in) :: self
        integer, intent(in) :: k            !! From 1
        real(dp) :: place(3)

        place = (k - (self%number + 1)/2.0_dp)*self%spacing
    end function place

    !> The unit vector along the line, body axes; 0 of one accelerometer.
    pure function direction(self)
        class(accelerometer_line_t), intent(in) :: self
        real(dp) :: direction(3)

        direction = 0
        if (self%number > 1) direction = self%spacing/norm2(self%spacing)
    end function direction

    !> sqrt(sum r_k^2), m: by how much the first contrast sees M along the line.
    pure real(dp) function reach(self)
        class(accelerometer_line_t), intent(in) :: self

        reach = norm2(self%spacing)*sqrt(self%number*(self%number**2 - 1)/12.0_dp)
    end function reach

    !> c_jk, (accelerometer k, contrast j).
    pure function weights(self)
        class(accelerometer_line_t), intent(in) :: self
        real(dp) :: weights(self%number, self%number - 1)

        if (self%number == 2) weights = OF_TWO
        if (self%number == 3) weights = OF_THREE
    end function weights

    !> Means of all accelerometers in place of the samples of the first, and contrasts.
    pure subroutine combine(self, acceleration, further, contrasts)
        class(accelerometer_line_t), intent(in) :: self
        real(dp), intent(inout) :: acceleration(:, :)       !! Of the first, then the mean, (3, n), m/s^2
        real(dp), intent(in) :: further(:, :, :)            !! Of the others, (3, n, number - 1), m/s^2
        real(dp), allocatable, intent(out) :: contrasts(:, :)       !! (3 (number - 1), n), m/s^2

        real(dp) :: c(self%number, self%number - 1)
        integer :: j, k

        c = self%weights()
        allocate (contrasts(3*size(c, 2), size(acceleration, 2)))
        do j = 1, size(c, 2)
            contrasts(3*j - 2:3*j, :) = c(1, j)*acceleration
            do k = 2, self%number
                contrasts(3*j - 2:3*j, :) = contrasts(3*j - 2:3*j, :) + c(k, j)*further(:, :, k - 1)
            end do
        end do
        acceleration = (acceleration + sum(further, 3))/self%number
    end subroutine combine

    !> Group accelerometers: nothing, unless there are several.
    subroutine describe_line(settings, line)
        class(settings_t), intent(inout) :: settings
        type(accelerometer_line_t), intent(inout) :: line

        if (line%number == 1 .and. .not. settings%holds('accelerometers')) return
        call settings%group('accelerometers', 'Two or three on a line; the offset is that of their middle')
        call settings%integer_value('number', line%number, 1, MOST, 'of accelerometers')
        call settings%real_values('spacing', line%spacing, -10.0_dp, 10.0_dp, 'm, from one to the next, body axes', unit='m', &
                                  required=.true.)
        call settings%real_values('scale_sigma', line%scale_sigma, 1e-12_dp, 1.0_dp, &
                                  'of what their scale factors differ by, relative; a simulation draws it')
        if (line%number > 1 .and. norm2(line%spacing) < CLOSEST) &
            call settings%reject('spacing', 'is less than 1 mm: the accelerometers must stand apart')
        call settings%end_group()
    end subroutine describe_line
end module gracecg_observations_accelerometer_line
