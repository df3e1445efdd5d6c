!> The true arc of a simulation as a CSV file.
module gracecg_simulation_truth_file
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_environment_time, only: time_tag
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, ATTITUDE, OMEGA
    use gracecg_simulation_accelerometer, only: pmc_acceleration_t
    use gracecg_simulation_simulator, only: simulator_t, disturbance_at
    use gracecg_files_csv, only: csv_writer_t
    implicit none
    private
    public :: open_truth, append_truth

    character(*), parameter :: COLUMNS = &
        'time_s,rx_m,ry_m,rz_m,vx_m_s,vy_m_s,vz_m_s,q1,q2,q3,q4,wx_rad_s,wy_rad_s,wz_rad_s,'// &
        'wdx_rad_s2,wdy_rad_s2,wdz_rad_s2,bx_tesla,by_tesla,bz_tesla,ngx_m_s2,ngy_m_s2,ngz_m_s2'

contains

    !> Begins the file. It stands when it is committed.
    subroutine open_truth(file, path, comments, error)
        type(csv_writer_t), intent(inout) :: file
        character(*), intent(in) :: path            !! Of the file to write; an existing one is replaced
        character(*), intent(in) :: comments(:)     !! For what tells of the file beside it
        type(error_t), allocatable, intent(out) :: error

        call file%open(path, COLUMNS, comments, error)
    end subroutine open_truth

    !> Writes every epoch of the arc, or of a piece of it those that the piece before did not have: position (m) and
    !> velocity (m/s) in the inertial frame, attitude (inertial to body), angular velocity (rad/s) and acceleration
    !> (rad/s^2), magnetic flux density (T) and non-gravitational acceleration (m/s^2), the last four in body axes.
    subroutine append_truth(file, simulator, wave)
        type(csv_writer_t), intent(inout) :: file   !! Of `open_truth`
        type(simulator_t), intent(in) :: simulator
        type(density_wave_t), intent(in) :: wave    !! The density wave of the run

        type(pmc_acceleration_t) :: acceleration
        integer :: k

        associate (arc => simulator%arc)
            do k = merge(0, arc%first + 1, arc%first == 0), arc%last
                acceleration = disturbance_at(simulator%case, arc, wave, k)
                associate (state => arc%state(:, k))
                    call file%row([time_tag(k, arc%interval), state(POSITION), state(VELOCITY), &
                                   state(ATTITUDE), state(OMEGA), arc%omega_dot(:, k), &
                                   arc%loads(k)%field, acceleration%non_gravitational])
                end associate
            end do
        end associate
    end subroutine append_truth
end module gracecg_simulation_truth_file
